"""Being written right now by the meshes helper (taken over from the town helper, who does ground, blocks and town). Do not edit."""
