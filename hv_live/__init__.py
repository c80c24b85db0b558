"""Talk to the humanoid, live: the simulation that listens, the page that shows it, and the server between them."""
