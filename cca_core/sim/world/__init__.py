"""The world around the ego in simulation: traffic, radio, sensor."""
