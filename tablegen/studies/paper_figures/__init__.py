"""The figures and the table of Panfilov and Tsirkunov (2022), from the direct model and a table."""
