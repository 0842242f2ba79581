"""The claims themselves: each module is found by its being here."""
