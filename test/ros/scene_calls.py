"""Service calls that many tests make, and the messages they need."""

from drake_geom_msgs import msg, srv
from geometry_msgs.msg import Pose


def poses(frames, rows, source='', stamp=None):
    """Return a FramePoses message; ``rows`` holds x y z, or all seven numbers, a frame."""
    message = msg.FramePoses(source=source, frame_names=list(frames))
    for row in rows:
        numbers = list(map(float, row))
        message.poses.extend(numbers if len(numbers) == 7 else [*numbers, 0.0, 0.0, 0.0, 1.0])
    if stamp is not None:
        message.header.stamp.sec = stamp
    return message


def accepted(response):
    """Return a response that must be a success."""
    assert response.success, response.message
    return response


def refused(response, *words):
    """Return the message of a response that must be a refusal naming ``words``."""
    assert not response.success
    for word in words:
        assert word in response.message
    return response.message


def place_of(client, frame):
    """Return where a frame is in the world, x y z; None while it waits for its first pose."""
    answer = client.call(srv.GetPose, 'get_pose', frame=frame)
    if not answer.success and 'never had a pose' in answer.message:
        return None
    p = accepted(answer).pose.pose.position
    return p.x, p.y, p.z


def add_sphere(client, source, frame, radius, name='ball', roles=(1,)):
    """Register a frame and a sphere on it; return the geometry's id."""
    accepted(client.call(srv.RegisterFrame, 'register_frame', source=source, name=frame))
    request = {
        'source': source,
        'frame': frame,
        'name': name,
        'pose': Pose(),
        'shape': msg.Shape(type=msg.Shape.SPHERE, dimensions=[radius]),
        'roles': [msg.Role(role=role) for role in roles],
    }
    answer = client.call(srv.RegisterGeometry, 'register_geometry', **request)
    return accepted(answer).geometry_id


def add_pair(client, source):
    """Register a source with two spheres of radius 0.1 and 0.2 on frames a and b."""
    accepted(client.call(srv.RegisterSource, 'register_source', name=source))
    return [add_sphere(client, source, 'a', 0.1), add_sphere(client, source, 'b', 0.2)]


def exclude(*geometries):
    """Return a declaration that excludes the pairs within geometries named."""
    return declaration(msg.CollisionFilterStatement.EXCLUDE_WITHIN, geometries)


def declaration(operation, geometries, others=()):
    """Return a declaration of one statement."""
    statement = msg.CollisionFilterStatement(
        operation=operation,
        set_a=msg.GeometrySet(geometries=list(geometries)),
        set_b=msg.GeometrySet(geometries=list(others)),
    )
    return msg.CollisionFilterDeclaration(statements=[statement])
