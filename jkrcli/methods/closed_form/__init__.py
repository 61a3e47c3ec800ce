"""The method ``closed-form``: bodies whose solution is a formula."""
