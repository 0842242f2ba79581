"""Tools of the developers: what calls cost, what requested digits deliver, what checks catch."""
