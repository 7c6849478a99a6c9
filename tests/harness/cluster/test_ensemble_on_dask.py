"""An ensemble on a cluster of two processes has the bits of one in this process."""

import pytest
from gnomon.harness.cluster.ensemble_on_dask import execute_there, on_cluster
from gnomon.harness.ensembles import ensemble_run
from gnomon.harness.ensembles.distribution import as_data
from gnomon.harness.ensembles.draws import Varied
from gnomon.harness.ensembles.ensemble_run import Job
from gnomon.harness.ensembles.samples import Ensemble

GAUSS = Ensemble(
    "pendulum_simple", "gnomon:Gauss 8-stage SIMD", 1e-6, (Varied("theta", -7.0, 7.0), Varied("omega", -8.0, 8.0))
)


@pytest.mark.slow
def test_a_cluster_gives_the_same_bits() -> None:
    job = Job(GAUSS, 1000, sides=(0, 1))
    with on_cluster("local", 2, GAUSS) as mapper:
        found = ensemble_run.run(job, mapper)
    alone = ensemble_run.run(job)
    assert as_data(found) == as_data(alone)
    assert found.worst == alone.worst


def test_a_worker_of_another_version_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"a worker has numpy .*, the client numpy 1\.0"):
        execute_there({"numpy": "1.0"}, Job(GAUSS, 256), 0)
