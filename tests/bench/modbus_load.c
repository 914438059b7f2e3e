/* Load generator: each of N connections keeps one request (function 3, 10 registers from 0) on its way.
 * Usage: modbus_load PORT CLIENTS SECONDS; prints answers (all of them), answers per second, and p50 and p99 of
 * the round trip in us; the first 0.2 s are not measured. */
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { ANSWER = 29, MOST = 256, BUCKETS = 100000 };

static unsigned histogram[BUCKETS]; /* by microsecond */

static long long now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static int fail(const char *what)
{
    perror(what);
    return 1;
}

static unsigned percentile(unsigned long long total, double percent)
{
    unsigned long long seen = 0;
    for (unsigned us = 0; us < BUCKETS; us++)
        if ((seen += histogram[us]) > total * percent / 100)
            return us;
    return BUCKETS;
}

int main(int argc, char **argv)
{
    if (argc != 4)
        return 2;
    int clients = atoi(argv[2]), poll = epoll_create1(0);
    double seconds = atof(argv[3]);
    unsigned char request[12] = {0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 10}, answer[512];
    static int fds[MOST], have[MOST];
    static long long asked[MOST];
    struct sockaddr_in server = {.sin_family = AF_INET, .sin_port = htons(atoi(argv[1]))};
    server.sin_addr.s_addr = htonl(INADDR_LOOPBACK);

    for (int i = 0; i < clients && i < MOST; i++) {
        int on = 1;
        fds[i] = socket(AF_INET, SOCK_STREAM, 0);
        if (connect(fds[i], (struct sockaddr *)&server, sizeof server) < 0)
            return fail("connect");
        setsockopt(fds[i], IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        struct epoll_event event = {.events = EPOLLIN, .data.u32 = i};
        epoll_ctl(poll, EPOLL_CTL_ADD, fds[i], &event);
    }
    unsigned long long total = 0, answers = 0;
    long long begin = 0, warm = now_ns() + 200000000LL, end = warm + (long long)(seconds * 1e9), now = now_ns();
    for (int i = 0; i < clients; i++) {
        asked[i] = now;
        if (write(fds[i], request, sizeof request) != sizeof request)
            return fail("write");
    }
    while (now < end) {
        struct epoll_event events[MOST];
        int ready = epoll_wait(poll, events, MOST, 2000);
        if (ready <= 0)
            return fail("no answer");
        for (int k = 0; k < ready; k++) {
            int i = events[k].data.u32;
            ssize_t size = read(fds[i], answer, sizeof answer);
            if (size <= 0)
                return fail("read");
            have[i] += size;
            if (have[i] < ANSWER)
                continue;
            if (have[i] != ANSWER || (size == ANSWER && (answer[7] != 3 || answer[8] != 20)))
                return fail("not the answer");
            have[i] = 0;
            answers++;
            now = now_ns();
            if (now >= warm) {
                if (begin == 0)
                    begin = now;
                long long us = (now - asked[i]) / 1000;
                histogram[us < BUCKETS ? us : BUCKETS - 1]++;
                total++;
            }
            asked[i] = now;
            if (write(fds[i], request, sizeof request) != sizeof request)
                return fail("write");
        }
    }
    printf("%llu %.0f %u %u\n", answers, total / ((now - begin) / 1e9), percentile(total, 50), percentile(total, 99));
    return 0;
}
