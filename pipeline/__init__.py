"""Belvedere: which fixed camera viewpoint serves the teleoperation of a robot arm best."""

from pipeline.contract.lifetime import end_with_dvc

end_with_dvc()  # before anything heavy is imported
