"""The motion libraries of a MAx-4, under the names of the manual (3364-3400)."""

from fieldrig_devices.iec.host import Library, NativeBlock
from fieldrig_devices.max4.libraries import (
    cam,
    loading,
    multi_cam,
    positioning,
    scaling,
    torque_cam,
)
from fieldrig_devices.max4.libraries.controller import MotionController
from fieldrig_devices.max4.libraries.motion import Motion


def motion_libraries(controller: MotionController) -> list[Library]:
    """Return the libraries for one boot of a controller; they forget their profiles when the program is initialised."""
    motion = Motion(controller)
    cam_block = cam.cam_block(motion)
    motion.on_clear(cam_block.forget)
    blocks = {
        "cam": NativeBlock(cam_block.run, cam_block.cost_ns, forget=motion.clear),
        "multicam3": multi_cam.multi_cam_block(motion),
        "slavecam": cam.slave_cam_block(motion),
    }
    vario_cam = cam.TEXT + multi_cam.TEXT + loading.PROFILES_TEXT + scaling.TEXT
    return [
        Library("Basic.lib", positioning.TEXT, positioning.functions(motion), {}),
        Library("VarioCam.lib", vario_cam, {**loading.profile_functions(motion), **scaling.FUNCTIONS}, blocks),
        Library("CSpline.lib", loading.SPLINE_TEXT, loading.spline_functions(motion), {}),
        Library("TorqueCam.lib", torque_cam.TEXT, {}, {"torquecam": torque_cam.torque_cam_block(motion)}),
    ]
