"""Contacts: friction sets and laws, and Newton's method on many contacts. Imports lcp, knows no grasp."""
