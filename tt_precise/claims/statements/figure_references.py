"""Section 2.3: references to figures, and the figures' colours."""

from __future__ import annotations

from collections.abc import Mapping

from tt_precise.claims.claim import claim
from tt_precise.claims.verdicts import Check, Finding, misprint, statement, wording

# what each panel shows, after the captions; the text refers to it by figure number and letter
PANELS = {
    "2a": {"theta", "theta_dot"},
    "2b": {"phi_dot", "psi_dot"},
    "3a": {"nu_x", "nu_y"},
    "3b": {"omega_3", "omega_3_dot"},
    "3c": {"g_n"},
    "4": {"E", "E_rot", "E_pot", "E_trans"},
    "5": {"E_dot", "E_trans_dot", "E_pot_dot"},
    "6": {"tau_x", "tau_y", "tau_z"},
    "7a": {"D", "E_tilde"},
    "7b": {"D"},
    "7c": {"E", "E_tilde"},
}
NEEDED = {
    "sizes of the terms in nu_x, nu_y": {"nu_x", "nu_y"},
    "difference E~ - E": {"E", "E_tilde"},
}
PRINTED = {"sizes of the terms in nu_x, nu_y": "3b", "difference E~ - E": "3c"}
CORRECTED = {"sizes of the terms in nu_x, nu_y": "3a", "difference E~ - E": "7c"}


@claim(
    "FIG-14",
    quote="In Fig. 3b we cannot estimate the size of each term; the graph 3c where the difference "
    "E~ - E becomes largest",
    where="Sec. 2.3, end",
    definition="the panel named must show, by its caption, what the sentence speaks about; labels "
    "total_plots2 b and c are panels b and c of Figure 3",
    control={"references": CORRECTED},
)
def cross_references(references: Mapping[str, str] = PRINTED) -> Finding:
    """The last two references to figures name the panels that show what is spoken about."""

    def says(named: Mapping[str, str]) -> Check:
        return statement(
            all(NEEDED[what] <= PANELS[panel] for what, panel in named.items()),
            printed="; ".join(f"{what}: Fig. {panel}" for what, panel in named.items()),
            measured="; ".join(
                f"Fig. {panel} shows {', '.join(sorted(PANELS[panel]))}" for panel in named.values()
            ),
        )

    return misprint(
        says(references),
        says(CORRECTED),
        "Fig. 3a and Fig. 7c",
        "Fig. 3b shows the spin and Fig. 3c the normal force.",
    )


@claim(
    "FIG-16",
    quote="(blue), (yellow), (grey), (green), (red); light blue line",
    where="captions of Figs 2 to 7; Sec. 2.3",
    definition="",
    control=None,
)
def colours() -> Finding:
    """The figures show the curves in the colours that captions and text name."""
    return wording(
        "The source at hand comes without the pictures, so their colours cannot be seen; the "
        "captions of Figs 4 and 6 name none, and Fig. 7 names only that of E.",
        printed="colours of curves",
    )
