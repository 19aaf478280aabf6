"""The catalogue: what may be wrong with a model, one small declaration each.

A new cause that frees an existing parameter is one new file here and no edit elsewhere.
"""
