"""A 3-D transient heat and quasi-static thermo-elastic finite-element model, on scikit-fem.

The mesh idea, materials and boundary conditions are those of [1] P. Poonyapak, M.J.D. Hayes, J.M.J. McDill,
"Temperature-Induced Deformation in a Mechanical System", section V. Needs the extra `warmlink[fea]`.
"""
