"""The rules, one light file each: what is known of them before their functions are imported."""
