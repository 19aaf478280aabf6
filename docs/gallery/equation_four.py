"""The paper's Eq. (4).

Growth of a link whose base is suddenly 14 K warmer. As printed, the expression shrinks with time;
integrated over the length of the link, the temperatures of a semi-infinite solid make it grow.
"""

import numpy as np
import pandas

import warmlink as wl
from warmlink.controllers.analytic.law import corrected, printed

times = np.linspace(60.0, 3600.0, 200)
depths = np.sqrt(167 / (2713 * 892) * times)
lines = {
    f"{name} [m]": [float(form(14.0, depth, 0.2916, 23.6e-6)) for depth in depths]
    for name, form in {"as printed": printed, "corrected": corrected}.items()
}
figure = wl.plot(pandas.DataFrame({"time [s]": times, **lines}), "as printed", "corrected")
