"""Heat and quasi-static thermo-elasticity of solids by finite elements, on scikit-fem."""
