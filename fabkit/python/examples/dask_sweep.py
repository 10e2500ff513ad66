"""Carry out a plan on a Dask cluster.

    pip install "fabkit-cad[dask]"
    python dask_sweep.py sweep.yaml out                      # two workers on this machine
    python dask_sweep.py sweep.yaml out tcp://scheduler:8786 # a cluster that is there

On Slurm, make the client with dask-jobqueue and give it to `run` in place of the address.
"""

import sys

import fabkit


def main(plan: str, out: str, address: str | None = None) -> None:
    """Compute the rows wherever there are workers; the tables are the command's."""
    if address is not None:
        sweep = fabkit.sweep.run(plan, out, executor=address, resume=False)
    else:
        from distributed import Client, LocalCluster

        with LocalCluster(n_workers=2, threads_per_worker=1) as cluster, Client(cluster) as client:
            sweep = fabkit.sweep.run(plan, out, executor=client)
    print(f"{sweep.folder}: {sweep.status}")


if __name__ == "__main__":
    main(*sys.argv[1:])
