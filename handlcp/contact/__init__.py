"""Contacts: friction sets and laws, where shapes touch and how contacts move. Imports lcp, knows no grasp."""
