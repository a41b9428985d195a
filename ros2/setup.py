"""Installation of the ROS 2 package; cca-planner itself comes from pip."""

from setuptools import setup

setup(
    name="cca_core_ros",
    version="0.2.0",
    packages=["cca_core_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/cca_core_ros"]),
        ("share/cca_core_ros", ["package.xml"]),
    ],
    install_requires=["setuptools", "cca-planner"],
    entry_points={"console_scripts": ["planner = cca_core_ros.node:main"]},
)
