"""A spindle, written for pythonfmu: an FMU that warmlink did not make, without units. All numbers are SI."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

START = {
    Fmi2Causality.input: {"speed": 0.0, "room": 295.15, "column": 295.15},
    Fmi2Causality.parameter: {"friction": 0.3, "capacity": 4000.0, "loss": 1.0, "flange": 2.0},
    Fmi2Causality.output: {"temperature": 295.15, "heat": 0.0},
}


class Spindle(Fmi2Slave):
    """A bearing that warms with speed, cooled by the room and by the column that it is mounted on."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for causality, values in START.items():
            for name, value in values.items():
                setattr(self, name, value)
                self.register_variable(Real(name, causality=causality))

    def do_step(self, time, step):
        """Euler's method, in four parts of a communication step."""
        for _ in range(4):
            self.heat = self.flange * (self.temperature - self.column)
            gained = self.friction * abs(self.speed) - self.loss * (self.temperature - self.room) - self.heat
            self.temperature += step / 4 * gained / self.capacity
        return True
