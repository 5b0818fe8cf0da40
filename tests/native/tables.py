"""The spacetimes whose deflection tables are tested."""

from bentlight_native import Spacetime

SPACETIMES = {
    "isotropic": Spacetime.schwarzschild(1.0),
    "areal": Spacetime.schwarzschild(2.5, "areal"),
    "ellis": Spacetime.ellis(1.5),
}
