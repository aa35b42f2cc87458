"""Ch. 2: destinations in a known map, and the belief over them."""
