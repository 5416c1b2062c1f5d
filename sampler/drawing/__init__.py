"""The draw of a rebound state: random words, normals, mixture, quantiles, frames, rough walls."""
