"""What judges answers: the laws that each must keep, and the surfaces that witnesses lie on."""
