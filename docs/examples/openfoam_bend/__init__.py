"""Sand in a bend of a duct in OpenFOAM: spheres, a table without the spin, and a table with it.

    python docs/examples/openfoam_bend FOLDER

blows corundum of 30 um through a bend of a square duct (`sampler/openfoam/cases/bend`), with air of
150 m/s from `simpleFoam`, three times: with OpenFOAM's own wall model for spheres, and with
`tabulatedRebound` without and with the spin of each parcel. OpenFOAM's `patchPostProcessing` writes
down every parcel that meets a wall, just before the wall model acts; here these impacts are sorted
by place. FOLDER is where install.sh and build.sh of sampler/openfoam worked, with
corundum-steel.rbt: `sampler/openfoam/bend.sh` does all of it in one command.

`many_hits bend` is the same bend in Python, plane, in a gas that is known by formula.
"""
