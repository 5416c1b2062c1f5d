"""Pages of the commands that write HTML: templates, one style, and how they are filled in."""
