"""The example of controllers/README.md."""

from warmlink import Law, Parameter, State, finite, where


class MyLaw(Law):
    """Growth by the mean of the temperatures at both ends of the link."""

    parameters = (Parameter("gain", "m/K", 6.9e-6, "growth per kelvin of mean rise", display="um/K"),)
    states = (State("reference", "K"), State("mean", "K"))

    def begin(self, u, p):
        mean = 0.5 * (u.base_temperature + u.tip_temperature)
        return {"reference": mean, "mean": mean}

    def update(self, x, u, p, time, step):
        mean = 0.5 * (u.base_temperature + u.tip_temperature)
        return {"reference": x.reference, "mean": where(finite(mean), mean, x.mean)}

    def correction(self, x, u, p, time):
        return p.gain * (x.mean - x.reference)
