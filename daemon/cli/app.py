"""The commands, their options and their help; what they do stands in the modules that they import."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from tendond import TendondError, __version__
from tendond.daemon.cli import log_commands
from tendond.daemon.cli.signals import leave_on_signals

app = typer.Typer(
    name="tendond",
    help="Controller for tendon-driven continuum robots: Cosserat rod model, Zenoh bus, MCAP log of every cycle.",
    no_args_is_help=True,
    rich_markup_mode=None,  # the rich help page takes longer to import than all the rest of the program
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

EXIT_FAILED = 1
EXIT_USAGE = 2

Config = Annotated[
    Path | None, typer.Option("--config", "-c", help="Rig configuration, TOML. Left out: the paper's robot.")
]
Profile = Annotated[
    str | None, typer.Option("--profile", help="Instead of --config: paper, rig or nasty, see docs/simulator.md.")
]
Lockstep = Annotated[
    bool, typer.Option("--lockstep", help="One cycle per pose instead of the clock; give it to run and simulate both.")
]
Cycles = Annotated[int | None, typer.Option("--cycles", min=1, help="End after so many cycles.")]


@app.callback(invoke_without_command=True)
def options(version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False) -> None:
    """Options of the program itself."""
    if version:
        print(f"tendond {__version__}")
        raise typer.Exit


@app.command()
def run(
    config: Config = None,
    profile: Profile = None,
    log: Annotated[
        Path | None, typer.Option("--log", help="MCAP file to write, a new one. Left out: log/RIG-TIME.mcap.")
    ] = None,
    lockstep: Lockstep = False,
    cycles: Cycles = None,
    arm_at: Annotated[
        int | None, typer.Option("--arm-at", min=0, help="Cycle to arm at; with --lockstep only.")
    ] = None,
) -> None:
    """Run the controller until Ctrl-C or SIGTERM; it starts disarmed.

    Example: tendond run --config rig.toml
    """
    leave_on_signals()
    from tendond.daemon.cli.run import run_controller

    if arm_at is not None and not lockstep:
        raise typer.BadParameter("only with --lockstep: a controller on a clock is armed by 'tendond arm'")
    run_controller(config, profile, log, lockstep=lockstep, cycles=cycles, arm_at=arm_at)


@app.command()
def simulate(
    config: Config = None,
    profile: Profile = None,
    lockstep: Lockstep = False,
    cycles: Cycles = None,
    wired: Annotated[
        bool, typer.Option("--wired", help="Emulate servos on a serial port and Tracker on UDP, for the real drivers.")
    ] = False,
) -> None:
    """Run the simulated robot in place of camera and servos, or behind their drivers.

    Examples: tendond simulate --config rig.toml; or tendond run --profile rig, and tendond simulate --profile rig
    """
    leave_on_signals()
    from tendond.daemon.cli.simulate import run_simulator, run_wired

    if wired:
        if lockstep or cycles is not None:
            raise typer.BadParameter("--wired goes by the clock, without --lockstep and --cycles")
        if profile is not None:
            raise typer.BadParameter("--wired needs --config, with the sections [servo] and [vicon]")
        run_wired(config)
        return
    run_simulator(config, profile, lockstep=lockstep, cycles=cycles)


@app.command()
def inject(
    fault: Annotated[str, typer.Argument(help="Which, see docs/simulator.md; mend ends it.")],
    config: Config = None,
    servo_id: Annotated[
        int | None, typer.Option("--servo", help="Id of the servo; of 'simulate', the first is 1.")
    ] = None,
    seconds: Annotated[float | None, typer.Option("--seconds", help="For how long.")] = None,
    size: Annotated[float | None, typer.Option("--size", help="How much [m, kg, N, or a part].")] = None,
    direction: Annotated[str | None, typer.Option("--direction", help="x, -x, y, -y, z or -z.")] = None,
    place: Annotated[float | None, typer.Option("--place", help="Along the rod, where 1 is the tip.")] = None,
) -> None:
    """Cause a fault on a running 'tendond simulate', with --wired or without.

    Of camera and arm: occlusion, frozen, teleport, dropout, noise, weight, impact, silence. Of a servo: overload,
    stuck; with --wired also silent, hot, reboot, and of the bus crc, unplug, plug.

    Examples: tendond inject weight --size 0.05; tendond inject overload --servo 3 --config rig.toml
    """
    from tendond.daemon.cli.simulate import inject_fault

    options = {"servo": servo_id, "seconds": seconds, "size": size, "direction": direction, "place": place}
    inject_fault(config, fault, options)


@app.command()
def vicon(config: Config = None) -> None:
    """Publish tip poses from Vicon Tracker until Ctrl-C or SIGTERM.

    Example: tendond vicon --config rig.toml
    """
    leave_on_signals()
    from tendond.daemon.cli.vicon import run_vicon

    run_vicon(config)


servo = typer.Typer(name="servo", help="Drive the servos, or find, set up and calibrate them.", rich_markup_mode=None)
app.add_typer(servo)

Yes = Annotated[bool, typer.Option("--yes", help="Do not ask.")]


@servo.callback(invoke_without_command=True)
def servo_run(context: typer.Context, config: Config = None) -> None:
    """Drive Dynamixel servos until Ctrl-C or SIGTERM, then let the tendons out and switch the torque off.

    Example: tendond servo --config rig.toml
    """
    if context.invoked_subcommand is None:
        leave_on_signals()
        from tendond.daemon.cli.servo import run_servo

        run_servo(config)


@servo.command("reset")
def servo_reset(config: Config = None) -> None:
    """Let the running driver leave its fault, or open its port again."""
    from tendond.daemon.cli.servo import reset_servos

    reset_servos(config)


@servo.command("scan")
def servo_scan(
    config: Config = None,
    port: Annotated[str | None, typer.Option("--port", help="Left out: every serial adapter.")] = None,
    last_id: Annotated[int, typer.Option("--last-id", min=0, max=252, help="Highest id to ask for.")] = 20,
) -> None:
    """Find servos: every port, every rate, every id; nothing is moved or changed."""
    leave_on_signals(130)
    from tendond.daemon.cli.servo import scan_servos

    scan_servos(config, port, last_id)


@servo.command("setup")
def servo_setup(
    servo_id: Annotated[int, typer.Argument(metavar="ID", min=0, max=252, help="Of the servo, as it is now.")],
    config: Config = None,
    new_id: Annotated[int | None, typer.Option("--new-id", min=0, max=252, help="Left out: as it is.")] = None,
    at: Annotated[int | None, typer.Option("--at", help="Rate that it listens at now. Left out: the rig's.")] = None,
    yes: Yes = False,
) -> None:
    """Set a servo's id, rate and mode.

    Example, a new servo: tendond servo setup 1 --new-id 3 --at 57600 --config rig.toml
    """
    from tendond.daemon.cli.servo import ask_terminal, set_up_servo

    set_up_servo(config, servo_id, new_id, at, yes, ask_terminal)


@servo.command("calibrate")
def servo_calibrate(config: Config = None) -> None:
    """Find zero, sign and spool of each tendon, and write the calibration; go on with an unfinished one."""
    leave_on_signals(130)
    from tendond.daemon.cli.servo import ask_terminal, calibrate_servos

    calibrate_servos(config, ask_terminal)


@servo.command("home")
def servo_home(config: Config = None, yes: Yes = False) -> None:
    """Bring every tendon slowly to its zero."""
    from tendond.daemon.cli.servo import ask_terminal, home_servos

    home_servos(config, yes, ask_terminal)


@servo.command("pretension")
def servo_pretension(
    config: Config = None,
    store: Annotated[bool, typer.Option("--store", help="Make the places found the calibration's zeros.")] = False,
    yes: Yes = False,
) -> None:
    """Wind every tendon up slowly until it begins to pull."""
    from tendond.daemon.cli.servo import ask_terminal, pretension_servos

    pretension_servos(config, store, yes, ask_terminal)


@app.command()
def arm(config: Config = None) -> None:
    """Arm: pretension, then track the reference."""
    from tendond.daemon.cli.operator import operate

    operate("arm", config)


@app.command()
def stop(config: Config = None) -> None:
    """Stop tracking and release the tendons."""
    from tendond.daemon.cli.operator import operate

    operate("stop", config)


@app.command()
def reset(config: Config = None) -> None:
    """Leave the fault mode, once its cause is gone."""
    from tendond.daemon.cli.operator import operate

    operate("reset", config)


@app.command()
def law(
    name: Annotated[str, typer.Argument(help="Of the law, for instance sliding_mode.")], config: Config = None
) -> None:
    """Select another control law while the arm is idle; its parameters are the configuration's."""
    from tendond.daemon.cli.operator import select_law

    select_law(name, config)


@app.command()
def reference(
    settings: Annotated[
        list[str], typer.Argument(metavar="KEY=VALUE...", help="Keys of [reference]; the others have their defaults.")
    ],
    config: Config = None,
) -> None:
    """Set another reference while the arm is idle; it is checked as the configuration's would be.

    Example: tendond reference across=0.3 kind=minimum_jerk duration=2.0
    """
    from tendond.daemon.cli.operator import set_reference

    set_reference(settings, config)


@app.command()
def status(
    config: Config = None,
    json: Annotated[bool, typer.Option("--json", help="Print the status message as JSON.")] = False,
) -> None:
    """Print what the controller is doing."""
    from tendond.daemon.cli.operator import show_status

    show_status(config, as_json=json)


@app.command()
def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for log, figures and summary.")] = Path("out/demo"),
    profile: Annotated[str, typer.Option("--profile", help="paper, rig or nasty, see docs/simulator.md.")] = "paper",
) -> None:
    """Simulate the paper's experiment, with log and figures.

    Controller and simulator are two processes on Zenoh, in real time; takes about ten seconds.

    Example, with the servos' real speed: tendond demo --profile rig --out out/demo-rig
    """
    leave_on_signals(130)
    from tendond.daemon.cli.demo import run_demo

    run_demo(out, profile)


@app.command()
def paper(
    out: Annotated[Path, typer.Option("--out", help="Folder for page, tables and figures.")] = Path("out/paper"),
    processes: Annotated[
        int | None, typer.Option("--processes", min=1, help="To share the work. Left out: one per processor.")
    ] = None,
) -> None:
    """Reproduce the paper: every simulation, its tables and figures beside the paper's numbers.

    Offline, in lockstep; takes about a minute.
    """
    leave_on_signals(130)
    from tendond.daemon.cli.paper import run_paper

    run_paper(out, processes)


@app.command()
def robustness(
    config: Config = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for table, summary, figure and report.")] = Path(
        "out/robustness"
    ),
    points: Annotated[
        str, typer.Option("--points", help="Which plants: default, axes, corners, grid or sample.")
    ] = "default",
    law: Annotated[list[str] | None, typer.Option("--law", help="Only this law; may be repeated.")] = None,
    feedback: Annotated[
        list[str] | None, typer.Option("--feedback", help="Only force, offset or direct; may be repeated.")
    ] = None,
    count: Annotated[
        int | None, typer.Option("--count", min=1, max=1_000_000, help="Random points per law. Left out: 50.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of noise and random points.")] = 0,
    jobs: Annotated[
        int | None, typer.Option("--jobs", "-j", min=1, max=1024, help="Processes. Left out: one per core.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", help="Dask scheduler to run on instead, for instance tcp://HOST:8786.")
    ] = None,
    fresh: Annotated[bool, typer.Option("--fresh", help="Leave aside the results that the folder has.")] = False,
) -> None:
    """Run the closed loop on plants that differ from the model: delay, lag, noise, stiffness, loads, impacts.

    axes: one thing at a time, for every feedback; corners: all extremes together; grid: every combination (an hour);
    sample: random plants; default: all but the grid. The plant is the configuration's [rod], changed.

    The default set takes about two minutes on two cores. Interrupted, the same command goes on where it was.

    Example: tendond robustness --points axes --feedback force
    """
    leave_on_signals(130)
    from tendond.daemon.cli.robustness import run_robustness
    from tendond.daemon.robustness.points import FEEDBACKS, POINT_SETS, SAMPLE_SIZE

    if points not in POINT_SETS:
        raise typer.BadParameter(f"'{points}': choose one of {', '.join(POINT_SETS)}", param_hint="--points")
    for name in feedback or ():
        if name not in FEEDBACKS:
            raise typer.BadParameter(f"'{name}': choose among {', '.join(FEEDBACKS)}", param_hint="--feedback")
    if count is not None and points not in ("default", "sample"):
        raise typer.BadParameter(f"the set '{points}' has no random points", param_hint="--count")
    run_robustness(
        config,
        out,
        points,
        tuple(law or ("backstepping", "sliding_mode")),
        tuple(feedback) if feedback else None,
        count=SAMPLE_SIZE if count is None else count,
        seed=seed,
        jobs=jobs,
        cluster=cluster,
        fresh=fresh,
    )


@app.command("rig-demo")
def rig_demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for log, figures and summary.")] = Path("out/rig-demo"),
) -> None:
    """Simulate the robot behind its real drivers: servos on a serial line, Tracker on UDP; takes half a minute."""
    leave_on_signals(130)
    from tendond.daemon.cli.demo import run_rig_demo

    run_rig_demo(out)


bench = typer.Typer(name="bench", help="Measure how long things take.", no_args_is_help=True, rich_markup_mode=None)
app.add_typer(bench)


@bench.command("rod")
def bench_rod(
    json: Annotated[Path | None, typer.Option("--json", help="File to write the rows to.")] = None,
    against: Annotated[Path | None, typer.Option("--against", help="File of an earlier run, to compare with.")] = None,
) -> None:
    """Time the rod's solvers and their errors, all in one run.

    Example: tendond bench rod --json now.json --against before.json
    """
    from tendond.daemon.cli.bench import run_bench_rod

    run_bench_rod(json, against)


@bench.command("loop")
def bench_loop(
    seconds: Annotated[float, typer.Option("--seconds", min=1.0, max=3600.0, help="Of each run.")] = 10.0,
    json: Annotated[Path | None, typer.Option("--json", help="File to write the rows to.")] = None,
) -> None:
    """Time the controller's loop beside a bare one: wake-up, work of a cycle, pose to command, recorder.

    Real processes on a real bus; takes about six times SECONDS. On a busy machine only the ratios mean something.

    Example: tendond bench loop --json now.json
    """
    leave_on_signals(130)
    from tendond.daemon.cli.bench_loop import run_bench_loop

    run_bench_loop(seconds, json)


@bench.command("schemes")
def bench_schemes() -> None:
    """Compare space schemes: error against time, as a Markdown table."""
    from tendond.daemon.cli.bench import run_bench_schemes

    run_bench_schemes()


@bench.command("profiles")
def bench_profiles() -> None:
    """Run both laws on each profile of the simulator: how long they take, as a Markdown table."""
    from tendond.daemon.bench.profiles import table

    print(table())


log_commands.add_to(app)


def main() -> None:
    """Run the command line; what a user can mend is one line each and no traceback."""
    try:
        app()
    except TendondError as error:
        for line in str(error).splitlines():
            print(f"tendond: {line}", file=sys.stderr)
        raise SystemExit(_exit_code(error)) from None
    except KeyboardInterrupt:
        raise SystemExit(130) from None


def _exit_code(error: TendondError) -> int:
    from tendond.daemon.errors import UsageError
    from tendond.schemas.config import ConfigError

    return EXIT_USAGE if isinstance(error, (ConfigError, UsageError)) else EXIT_FAILED
