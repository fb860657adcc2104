#include "outlet.h"

#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio_ext.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "crash.h"
#include "poll_any.h"
#include "thread.h"

enum { WHOLE = 4096 /* PIPE_BUF: a write of up to this size is never split */, ROOM = 1 << 20, GIVE_UP_S = 1 };

static void *copy(void *argument) {
    crash_stack();
    struct outlet *o = argument;
    char text[WHOLE];
    ssize_t size;
    while ((size = read(o->from, text, sizeof text)) > 0 || (size < 0 && errno == EINTR))
        for (ssize_t done = 0; done < size;) {
            ssize_t written = write(o->to, text + done, (size_t)(size - done));
            if (written < 0 && errno == EAGAIN) poll_any(&(struct pollfd){.fd = o->to, .events = POLLOUT}, 1, -1, NULL);
            else if (written < 0 && errno != EINTR) break; /* the reader has gone */
            if (written <= 0) continue;
            done += written;
            atomic_fetch_add_explicit(&o->copied, 1, memory_order_relaxed);
        }
    return NULL;
}

int outlet_open(struct outlet *o, int to) {
    struct error error;
    int end[2];
    *o = (struct outlet){.to = to};
    if (pipe2(end, O_CLOEXEC)) return -1;
    fcntl(end[1], F_SETFL, O_NONBLOCK);
    fcntl(end[1], F_SETPIPE_SZ, ROOM); /* the system may grant a smaller pipe */
    o->from = end[0], o->into = end[1];
    o->out = fdopen(end[1], "w");
    if (o->out && !setvbuf(o->out, NULL, _IOFBF, WHOLE) && !thread_start(&o->thread, "terminal", THREAD_STACK_COPY, copy, o, &error))
        return 0;
    close(end[0]);
    if (o->out) fclose(o->out);
    else close(end[1]);
    return -1;
}

void outlet_flush(struct outlet *o) {
    if (!fflush(o->out)) return;
    __fpurge(o->out);
    clearerr(o->out);
}

void outlet_write(struct outlet *o, const char *text) {
    if (write(o->into, text, strlen(text)) < 0) return; /* the pipe is full */
}

bool outlet_close(struct outlet *o) {
    long before;
    outlet_flush(o);
    fclose(o->out);
    do {
        before = atomic_load(&o->copied);
        if (thread_join_within(o->thread, GIVE_UP_S)) {
            close(o->from);
            return true;
        }
    } while (atomic_load(&o->copied) != before);
    return false;
}
