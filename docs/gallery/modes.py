"""What an observer's reduced model leaves out.

Hankel singular values of motor and link: each says how much a pattern of temperatures passes from the
inputs to the outputs. They fall off so fast that seven of 42 patterns are enough.
"""

import plotly.graph_objects as go

from warmlink.controllers.design.plant import plant_model
from warmlink.controllers.design.reduction import balanced

values = balanced(plant_model()).hankel
figure = go.Figure(go.Bar(x=list(range(1, 21)), y=values[:20], name="strength"))
figure.update_xaxes(title="pattern")
figure.update_yaxes(title="Hankel singular value", type="log")
