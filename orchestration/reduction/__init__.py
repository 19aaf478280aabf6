"""A solid becomes a thermal link: finite elements, their reduction, and what its error is bounded by.

Needs the extra `warmlink[cad]`.
"""
