"""Contacts on any link: what may touch, where it touches an object, and the hand that touches there."""
