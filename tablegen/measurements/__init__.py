"""Measured rebounds as data: files of the package and of users, and their reader."""
