"""Many units, and records that do not fit on one machine (docs/fleet.md).

    from tumble import fleet
    units = fleet.run("plan.toml", "data/*.h5", "fleet")
    units.table().to_pandas()
    units.report("fleet.html", limits={"x.bias": ("-1 mg", "1 mg")})
    fleet.record("allan_noise", "year/*.h5", "year.fleet")

Works on the processors of this machine, or on a cluster of Dask: `executor=distributed.Client(...)`. Needs
`pip install 'tumble[fleet]'`.
"""

from tumble.fleet._fleet import Fleet, Status
from tumble.fleet._record import record
from tumble.fleet._run import run

__all__ = ["Fleet", "Status", "record", "run"]
