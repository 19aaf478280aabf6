"""The catalogue: what may be wrong with a model, one TOML file for each cause, named after it.

A new cause that frees an existing parameter is one new file here and no edit elsewhere.
"""
