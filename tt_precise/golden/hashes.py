"""The hashes in a manifest, and how it is written with them."""

from __future__ import annotations

import hashlib
import json
import tomllib

from tt_precise.runtime.untyped import Json

SELF_HASH = "sha256_of_manifest"
PROOF, PROOF_KEY = "proof.json", "sha256_of_proof"


def dump(manifest: dict[str, Json]) -> str:
    """The text of manifest.json, with the manifest's own hash added."""
    sealed = {**manifest, SELF_HASH: self_hash(manifest)}
    return json.dumps(sealed, indent=1, ensure_ascii=False) + "\n"


def with_proof(manifest: dict[str, Json], sha256: str | None) -> dict[str, Json]:
    """The manifest (without its own hash) of data whose proof has that hash, or that have none."""
    content = {k: v for k, v in manifest.items() if k not in (SELF_HASH, PROOF_KEY)}
    return content if sha256 is None else {**content, PROOF_KEY: sha256}


def self_hash(manifest: dict[str, Json], name: str = SELF_HASH) -> str:
    """SHA-256 of a manifest's content, without this hash itself, which it has under ``name``."""
    content = {key: value for key, value in manifest.items() if key != name}
    text = json.dumps(content, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def scene_sha256(text: str) -> str:
    """SHA-256 of what a scene's TOML says, comments and layout apart."""
    parsed = tomllib.loads(text, parse_float=str)
    canonical = json.dumps(parsed, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()
