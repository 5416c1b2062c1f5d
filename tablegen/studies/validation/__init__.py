"""The validation of a table as text and as a page, and the accuracy stored in its file."""
