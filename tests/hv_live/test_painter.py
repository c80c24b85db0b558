import threading

import cv2
import numpy as np
import pytest

from hv_live.live_world import LiveWorld
from hv_live.painter import HEAD_PX, THIRD_PERSON_PX, Painter, camera_of
from hv_live.protocol import Orbit
from hv_sim.task import load_task


def test_both_views_arrive_as_jpeg_from_another_thread():
    world = LiveWorld(load_task("living_room_1"))
    arrived, free = [], threading.Event()
    painter = Painter(lambda picture: arrived.append((picture, threading.get_ident())), free.set)
    camera = camera_of((0.0, 0.0), np.array([2.5, 2.0, 2.3]), (6.0, 5.0), None)

    def copy(data):
        world.physics.data(0, data)

    assert not painter.paint(copy, camera), "no scene yet"
    painter.load(world.physics.model(0))
    assert painter.paint(copy, camera)
    assert free.wait(20)
    painter.free()
    assert not painter.paint(copy, camera)
    painter.close()
    [(picture, thread)] = arrived
    assert thread != threading.get_ident()
    length = int.from_bytes(picture[:4], "big")
    for jpeg, size in ((picture[4 : 4 + length], THIRD_PERSON_PX), (picture[4 + length :], HEAD_PX)):
        shown = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        assert shown.shape == (*size, 3)
        assert shown.std() > 10


@pytest.mark.parametrize("azimuth_deg", range(0, 360, 30))
def test_a_dragged_camera_stays_between_the_walls(azimuth_deg):
    corner = np.array([2.5, 2.0, 2.3])
    camera = camera_of((2.0, -1.5), corner, (6.0, 5.0), Orbit(azimuth_deg, -15, 12.0))
    azimuth, elevation = np.radians(camera.azimuth), np.radians(camera.elevation)
    ahead = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    eye = np.asarray(camera.lookat) - camera.distance * ahead
    assert np.all(np.abs(eye[:2]) <= np.array([3.0, 2.5]) - 0.1)
    assert camera.distance >= 0.7
    assert camera_of((2.0, -1.5), corner, (6.0, 5.0), Orbit(azimuth_deg, -85, 5.0)).distance > 2.0, "from above"
