"""What geometry alone says of a viewpoint: no network, no policy, seconds instead of minutes."""
