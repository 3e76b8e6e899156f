"""The group `tendond rig`: everything done with a rig, real or simulated."""

import typer

from tendond.cli.dashboard.commands import dashboard
from tendond.cli.rig.doctor_commands import doctor
from tendond.cli.rig.operator_commands import arm, law, reference, reset, status, stop, watch
from tendond.cli.rig.process_commands import inject, run, simulate, vicon
from tendond.cli.rig.teach_commands import teach
from tendond.cli.rig.tuning_commands import get, set_
from tendond.cli.teleop.commands import teleop

rig = typer.Typer(
    name="rig", help="Run, operate and diagnose a rig, real or simulated.", no_args_is_help=True, rich_markup_mode=None
)
for command in (
    run,
    simulate,
    vicon,
    arm,
    stop,
    reset,
    status,
    law,
    reference,
    watch,
    dashboard,
    teleop,
    doctor,
    inject,
):
    rig.command()(command)
rig.command("set")(set_)
rig.command("get")(get)
rig.add_typer(teach)
