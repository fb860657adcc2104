"""Runs a command to which the kernel refuses CAN sockets (EPERM), as a security policy would.

    no_can.py COMMAND [ARGUMENT...]
"""
import ctypes
import errno
import os
import socket
import sys


class Comparison(ctypes.Structure):
    """struct scmp_arg_cmp"""

    _fields_ = [("arg", ctypes.c_uint), ("op", ctypes.c_int), ("a", ctypes.c_uint64), ("b", ctypes.c_uint64)]


ALLOW, REFUSE, EQUAL = 0x7FFF0000, 0x00050000 | errno.EPERM, 4  # SCMP_ACT_ALLOW, SCMP_ACT_ERRNO(EPERM), SCMP_CMP_EQ
seccomp = ctypes.CDLL("libseccomp.so.2")
seccomp.seccomp_init.restype = ctypes.c_void_p
context = ctypes.c_void_p(seccomp.seccomp_init(ALLOW))
family = Comparison(0, EQUAL, socket.AF_CAN, 0)
if seccomp.seccomp_rule_add_array(context, REFUSE, seccomp.seccomp_syscall_resolve_name(b"socket"), 1, ctypes.byref(family)):
    sys.exit("no_can.py: the rule was refused")
if seccomp.seccomp_load(context):
    sys.exit("no_can.py: the filter was refused")
os.execvp(sys.argv[1], sys.argv[1:])
