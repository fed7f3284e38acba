"""What moves and how far: travel of a rigid body, flexion of a joint, and what it carries along."""
