"""What a communication step costs.

FMUs exchange values at communication points only. Compared with steps of 0.25 s, Jacobi and Gauss-Seidel
err in proportion to the step, until at a minute the exchange itself becomes unstable.
"""

import numpy as np
import plotly.graph_objects as go

import warmlink as wl

exact = wl.run("stop_and_go", "none", step="0.25 s", stop="20 min").uncompensated_error[-1]
steps = [1, 2, 5, 10, 20, 30, 60]
figure = go.Figure()
for master in ("jacobi", "gauss_seidel"):
    ends = [wl.run("stop_and_go", "none", step=s, stop="20 min", master=master) for s in steps]
    errors = [1e6 * abs(run.uncompensated_error[-1] - exact) for run in ends]
    figure.add_scatter(x=steps, y=np.array(errors), name=master, mode="lines+markers")
figure.update_xaxes(title="communication step [s]", type="log", dtick=1)
figure.update_yaxes(title="error after 20 min [µm]", type="log", dtick=1)
