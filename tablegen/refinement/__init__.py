"""Where the nodes of a table are: a grid refined until the error between nodes is small enough."""
