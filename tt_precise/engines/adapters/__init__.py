"""Adapters: one engine a file, each a program of the engine protocol."""
