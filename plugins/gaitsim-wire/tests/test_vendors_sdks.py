"""The SDKs of Dynamixel and Feetech drive virtual robots."""

from types import SimpleNamespace

import numpy as np
import pytest
from wires import Wire, robot_on

from gaitsim_wire.emulator import Fault
from gaitsim_wire.tables import TABLES

dynamixel = pytest.importorskip("dynamixel_sdk")
feetech = pytest.importorskip("scservo_sdk")
SDKS = {"dynamixel": (dynamixel, 2.0), "feetech": (feetech, 0)}
IDS = range(1, 13)


@pytest.fixture(params=SDKS)
def opened(request, monkeypatch):
    """Return a function that lets a vendor's SDK open a robot, whose time the test advances."""
    sdk, version = SDKS[request.param]

    def begin(*faults, **options):
        wire = Wire(robot_on(request.param, *faults, **options))
        made = SimpleNamespace(Serial=lambda **settings: wire, EIGHTBITS=8)
        monkeypatch.setattr(f"{sdk.__name__}.port_handler.serial", made)
        port, packets = sdk.PortHandler("port"), sdk.PacketHandler(version)
        assert port.openPort()
        read = {1: packets.read1ByteTxRx, 2: packets.read2ByteTxRx, 4: packets.read4ByteTxRx}
        write = {1: packets.write1ByteTxRx, 2: packets.write2ByteTxRx, 4: packets.write4ByteTxRx}

        def get(number, part):
            value, result, error = read[part.size](port, number, part.address)
            assert (result, error) == (0, 0)
            return value

        def put(number, part, value):
            return write[part.size](port, number, part.address, value)

        return SimpleNamespace(
            wire=wire, body=wire.emulator.body, port=port, packets=packets, sdk=sdk, get=get,
            put=put, table=TABLES[request.param],
        )  # fmt: skip

    return begin


def test_servos_answer_and_move(opened):
    robot = opened()
    table = robot.table
    [model] = table.models.values()
    assert [robot.packets.ping(robot.port, number)[:2] for number in IDS] == [(model, 0)] * 12
    assert robot.packets.ping(robot.port, 13)[1] == robot.sdk.COMM_RX_TIMEOUT
    assert robot.get(5, table.mode) == table.position_mode
    assert robot.get(5, table.volts) == round(10 * table.voltage)
    assert robot.get(5, table.temperature) == 25
    position = robot.get(5, table.position)
    assert robot.put(5, table.goal, position + 100) == (0, 0)
    robot.wire.now += 0.2
    assert abs(robot.get(5, table.position) - position) < 60, "off"
    assert robot.put(5, table.torque, 1) == (0, 0)
    robot.wire.now += 0.5
    assert abs(robot.get(5, table.position) - position - 100) < 15
    assert robot.get(5, table.load) != 0


def test_servos_are_read_and_written_together(opened):
    robot = opened()
    table, sdk = robot.table, robot.sdk
    write = sdk.GroupSyncWrite(robot.port, robot.packets, table.torque.address, 1)
    for number in IDS:
        assert write.addParam(number, [1])
    assert write.txPacket() == 0
    first, length = table.watched
    read = sdk.GroupSyncRead(robot.port, robot.packets, first, length)
    for number in IDS:
        assert read.addParam(number)
    assert read.txRxPacket() == 0
    assert robot.body.on.all()
    part = table.position
    positions = [read.getData(number, part.address, part.size) for number in IDS]
    assert positions == [robot.get(number, part) for number in IDS]
    goals = [position + 40 for position in positions]
    write = sdk.GroupSyncWrite(robot.port, robot.packets, table.goal.address, table.goal.size)
    for number, goal in zip(IDS, goals, strict=True):
        assert write.addParam(number, [*table.goal.write(goal)])
    assert write.txPacket() == 0
    assert [robot.get(number, table.goal) for number in IDS] == goals


def test_faults_are_seen(opened):
    faults = Fault("dead", 2), Fault("twin", 3), Fault("hot", 4, 80.0), Fault("battery", -1, 5.0)
    robot = opened(*faults)
    module = robot.sdk
    assert robot.packets.ping(robot.port, 3)[1] == module.COMM_RX_TIMEOUT
    assert robot.packets.ping(robot.port, 4)[1] == module.COMM_RX_CORRUPT
    assert robot.get(5, robot.table.temperature) == 80
    assert robot.get(6, robot.table.volts) == 50


def test_goals_beyond_the_limits_are_refused(opened):
    robot = opened()
    goal = robot.get(1, robot.table.goal)
    error = 6 if robot.sdk is dynamixel else 0  # a data limit error
    assert robot.put(1, robot.table.goal, 5000) == (0, error)
    assert robot.get(1, robot.table.goal) == goal


def test_the_imu_is_that_of_an_opencr_board(opened):
    robot = opened()
    data, result, _ = robot.packets.readTxRx(robot.port, 200, 96, 16)
    assert result == 0
    turned = np.frombuffer(bytes(data), "<f4")
    assert turned == pytest.approx([1, 0, 0, 0], abs=0.1)
    robot = opened(imu=False)
    assert robot.packets.readTxRx(robot.port, 200, 96, 16)[1] != 0


def test_the_bus_watchdog_stops_the_servos(opened):
    robot = opened()
    watchdog, goal = robot.table.watchdog, robot.get(1, robot.table.goal)
    if watchdog is None:
        pytest.skip("the servo has none")
    robot.put(1, watchdog, 10)
    robot.wire.now += 0.1
    assert robot.put(1, robot.table.goal, goal + 10) == (0, 0)
    robot.wire.now += 0.3
    assert robot.get(1, watchdog) == 255
    assert robot.put(1, robot.table.goal, goal) == (0, 6)
    robot.put(1, watchdog, 0)
    assert robot.put(1, robot.table.goal, goal) == (0, 0)
