"""Firmware for Cortex-M: the C of native code, startup, linker script and scan for a board; run in QEMU."""
