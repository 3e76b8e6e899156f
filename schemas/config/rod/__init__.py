"""[[rod.section]], [[rod.tendon]], [rod.tip], [rod.base]: any robot, beside the short form of [rod] for one section."""
