/* The peer to measure against: libmodbus' own server, many connections in one select loop as in its examples. */
#include <arpa/inet.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <stdio.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <unistd.h>

int main(void)
{
    uint8_t query[MODBUS_TCP_MAX_ADU_LENGTH];
    modbus_t *server = modbus_new_tcp("127.0.0.1", 0);
    modbus_mapping_t *registers = modbus_mapping_new(0, 0, 100, 0);
    int listening = modbus_tcp_listen(server, 64), most = listening;
    struct sockaddr_in address;
    socklen_t size = sizeof address;
    fd_set open, ready;

    if (listening < 0 || registers == NULL || getsockname(listening, (struct sockaddr *)&address, &size) < 0)
        return 1;
    printf("%d\n", ntohs(address.sin_port));
    fflush(stdout);
    FD_ZERO(&open);
    FD_SET(listening, &open);
    for (;;) {
        ready = open;
        if (select(most + 1, &ready, NULL, NULL, NULL) < 0)
            return 1;
        for (int fd = 0; fd <= most; fd++) {
            if (!FD_ISSET(fd, &ready))
                continue;
            if (fd == listening) {
                int client = accept(listening, NULL, NULL);
                if (client >= 0) {
                    FD_SET(client, &open);
                    if (client > most)
                        most = client;
                }
                continue;
            }
            modbus_set_socket(server, fd);
            int length = modbus_receive(server, query);
            if (length > 0)
                modbus_reply(server, query, length, registers);
            else if (length < 0) {
                close(fd);
                FD_CLR(fd, &open);
            }
        }
    }
}
