/* Lets user-mode Linux 6.1 run on processors with AMX.
 *
 * The kernel saves and restores a process' floating-point state with PTRACE_GETREGSET and PTRACE_SETREGSET in a buffer
 * of a fixed size, which ends before the tiles of AMX.  Reading is cut short without harm, but Linux refuses to write a
 * state that is not whole, and the guest panics.  This library, preloaded into linux.uml, fills up what is missing with
 * zeros: a guest's process has no permission to use the tiles, so they are in their initial state.
 */
#define _GNU_SOURCE
#include <cpuid.h>
#include <dlfcn.h>
#include <elf.h>
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/uio.h>

#ifndef NT_X86_XSTATE
#define NT_X86_XSTATE 0x202
#endif

static unsigned char whole[64 * 1024];

/* The size in bytes of the state of all components that this processor and its kernel have enabled. */
static size_t whole_size(void)
{
    unsigned int a, b = 0, c, d;
    __cpuid_count(0xd, 0, a, b, c, d);
    return b;
}

long ptrace(enum __ptrace_request request, ...)
{
    static long (*real)(enum __ptrace_request, ...);
    va_list arguments;
    va_start(arguments, request);
    pid_t process = va_arg(arguments, pid_t);
    void *address = va_arg(arguments, void *);
    void *data = va_arg(arguments, void *);
    va_end(arguments);
    if (!real)
        real = dlsym(RTLD_NEXT, "ptrace");
    long result = real(request, process, address, data);
    if (result == 0 || request != PTRACE_SETREGSET || (long)address != NT_X86_XSTATE || errno != EFAULT)
        return result;
    struct iovec *given = data;
    size_t size = whole_size();
    if (given->iov_len >= size || size > sizeof whole)
        return result;
    memset(whole, 0, size);
    memcpy(whole, given->iov_base, given->iov_len);
    struct iovec filled = {whole, size};
    return real(request, process, address, &filled);
}
