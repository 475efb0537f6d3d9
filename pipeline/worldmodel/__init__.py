"""Floor 2: the world model of one viewpoint: what it sees (VAE) and what it expects (MDN-RNN)."""
