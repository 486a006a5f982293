/* A stand-in for PEAK's library PCAN-Basic, with the functions of its documented interface that canvass uses: channels that
 * are there or not, queues that overflow, statuses, error frames and time stamps.
 *
 * Tests in the same process say by the functions `stand_in_...` what happens on the bus. Where the environment variable
 * PCAN_STAND_IN holds a TCP port of this machine, the bus is what is behind it, in SLCAN: so programs meet a device.
 *
 *   cc -shared -fPIC -o libpcanbasic.so stand_in.c -lpthread
 *   x86_64-w64-mingw32-gcc -shared -static -o PCANBasic.dll stand_in.c -lws2_32 -lpthread
 */
#ifdef _WIN32
#include <winsock2.h>
#define EXPORT __declspec(dllexport)
#define CALL __stdcall
#else
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>
#define EXPORT __attribute__((visibility("default")))
#define CALL
#define closesocket close
typedef int SOCKET;
#endif
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct {
    uint32_t id;
    uint8_t type, length, data[8];
} Message;

typedef struct {
    uint32_t millis;
    uint16_t overflows, micros;
} Stamp;

enum {
    OK = 0, BUSES = 0x4001C, EMPTY = 0x20, QUEUE_OVERRUN = 0x40, QUEUE_FULL = 0x80, IN_USE = 0x400, NO_HARDWARE = 0x1400,
    UNKNOWN_PARAMETER = 0x4000, WRONG_VALUE = 0x8000, NOT_INITIALIZED = 0x4000000
};
enum { REMOTE = 1, EXTENDED = 2, ERROR_FRAME = 0x40, STATUS_MESSAGE = 0x80 };
enum { RECEIVE_EVENT = 3, API_VERSION = 5, BUS_OFF_RESET = 7, LISTEN_ONLY = 8, CONDITION = 0x0D, HARDWARE_NAME = 0x0E,
       ALLOW_STATUS = 0x1E, ALLOW_ERRORS = 0x20 };
enum { RECEIVE_QUEUE = 512, TRANSMIT_QUEUE = 16, CHANNELS = 16, SENT = 4096 };

/* The functions whose answer a test may say. */
enum { INITIALIZE, READ, WRITE, GET_STATUS, FUNCTIONS };

typedef struct {
    uint32_t condition, answers[FUNCTIONS], bus, lost, opened;
    uint32_t listen_only, allow_status, allow_errors;
    uint16_t registers;
    int is_open, holds;
    Message queue[RECEIVE_QUEUE], sent[SENT];
    uint64_t times[RECEIVE_QUEUE];
    unsigned first, count, sent_count, waiting;
    intptr_t event;
    SOCKET socket;
    int has_socket;
} Channel;

static Channel channels[CHANNELS];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

/* The channels PCAN_USBBUS1 to 16. */
static Channel *channel(uint16_t handle) {
    if (handle > 0x500 + 8 && handle <= 0x500 + CHANNELS)
        return &channels[handle - 0x501];
    return handle > 0x50 && handle <= 0x50 + 8 ? &channels[handle - 0x51] : NULL;
}

static int port(void) {
    const char *text = getenv("PCAN_STAND_IN");
    return text ? atoi(text) : 0;
}

static uint32_t condition(uint16_t handle) {
    if (handle == 0x51 && port() && !channels[0].condition)
        return 1;
    return channel(handle) ? channel(handle)->condition : 0;
}

static void wake(Channel *c) {
#ifdef _WIN32
    if (c->event)
        SetEvent((HANDLE)c->event);
#else
    uint64_t one = 1;
    if (c->event > 0 && write((int)c->event, &one, sizeof one) < 0)
        perror("eventfd");
#endif
}

/* Nothing is left: the descriptor is not to be read from. */
static void sleep_again(Channel *c) {
#ifndef _WIN32
    uint64_t all;
    if (c->event > 0 && read((int)c->event, &all, sizeof all) < 0)
        return;
#else
    (void)c;
#endif
}

static void push(Channel *c, Message message, uint64_t micros) {
    if ((message.type & ERROR_FRAME && !c->allow_errors) || (message.type & STATUS_MESSAGE && !c->allow_status))
        return;
    if (c->count == RECEIVE_QUEUE) {
        c->lost = QUEUE_OVERRUN;
        return;
    }
    unsigned at = (c->first + c->count++) % RECEIVE_QUEUE;
    c->queue[at] = message;
    c->times[at] = micros;
    wake(c);
}

static uint64_t now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (uint64_t)time.tv_sec * 1000000 + (uint64_t)time.tv_nsec / 1000;
}

/* A line of SLCAN as a message; 0 if it is no frame. */
static int parse(const char *line, Message *message) {
    int extended = line[0] == 'T' || line[0] == 'R', remote = line[0] == 'r' || line[0] == 'R', digits = extended ? 8 : 3;
    if (!strchr("tTrR", line[0]) || (int)strlen(line) < digits + 2)
        return 0;
    char id[9] = {0};
    memcpy(id, line + 1, (size_t)digits);
    *message = (Message){.id = (uint32_t)strtoul(id, NULL, 16)};
    message->type = (uint8_t)((extended ? EXTENDED : 0) | (remote ? REMOTE : 0));
    message->length = (uint8_t)(line[digits + 1] - '0');
    for (int n = 0; n < message->length && !remote; n++) {
        char byte[3] = {0};
        memcpy(byte, line + digits + 2 + 2 * n, 2);
        message->data[n] = (uint8_t)strtoul(byte, NULL, 16);
    }
    return message->length <= 8;
}

static void *listen_to(void *argument) {
    Channel *c = argument;
    char line[64], byte;
    unsigned length = 0;
    while (recv(c->socket, &byte, 1, 0) == 1) {
        Message message;
        if (byte != '\r') {
            if (length < sizeof line - 1)
                line[length++] = byte;
            continue;
        }
        line[length] = 0;
        length = 0;
        if (!line[0] || !parse(line, &message))
            continue;
        pthread_mutex_lock(&lock);
        if (c->is_open)
            push(c, message, now());
        pthread_mutex_unlock(&lock);
    }
    return NULL;
}

static int connect_to(Channel *c) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_port = htons((uint16_t)port())};
    int yes = 1;
    pthread_t thread;
#ifdef _WIN32
    WSADATA data;
    WSAStartup(MAKEWORD(2, 2), &data);
#endif
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    c->socket = socket(AF_INET, SOCK_STREAM, 0);
    setsockopt(c->socket, IPPROTO_TCP, TCP_NODELAY, (const char *)&yes, sizeof yes);
    if (connect(c->socket, (struct sockaddr *)&address, sizeof address))
        return 0;
    c->has_socket = 1;
    return pthread_create(&thread, NULL, listen_to, c) == 0 && pthread_detach(thread) == 0;
}

static void transmit(Channel *c, const Message *message) {
    char line[40];
    int extended = message->type & EXTENDED, remote = message->type & REMOTE;
    int length = snprintf(line, sizeof line, extended ? "%c%08X%d" : "%c%03X%d", "tTrR"[(extended ? 1 : 0) + (remote ? 2 : 0)],
                          (unsigned)message->id, message->length);
    for (int n = 0; n < message->length && !remote; n++)
        length += snprintf(line + length, sizeof line - (size_t)length, "%02X", message->data[n]);
    line[length++] = '\r';
    send(c->socket, line, (size_t)length, 0);
}

EXPORT uint32_t CALL CAN_Initialize(uint16_t handle, uint16_t registers, uint8_t type, uint32_t address, uint16_t interrupt) {
    Channel *c = channel(handle);
    uint32_t status = OK;
    (void)type, (void)address, (void)interrupt;
    pthread_mutex_lock(&lock);
    if (!c || !condition(handle))
        status = NO_HARDWARE;
    else if (c->answers[INITIALIZE])
        status = c->answers[INITIALIZE];
    else if (c->is_open)
        status = NOT_INITIALIZED;
    else if (condition(handle) == 2)
        status = IN_USE;
    else if (port() && !connect_to(c))
        status = NO_HARDWARE;
    if (status == OK) {
        c->is_open = 1;
        c->opened++;
        c->registers = registers;
        c->first = c->count = c->waiting = c->lost = 0;
#ifndef _WIN32
        c->event = eventfd(0, EFD_NONBLOCK);
#endif
    }
    pthread_mutex_unlock(&lock);
    return status;
}

EXPORT uint32_t CALL CAN_Uninitialize(uint16_t handle) {
    Channel *c = channel(handle);
    if (!c)
        return NO_HARDWARE;
    pthread_mutex_lock(&lock);
    uint32_t status = c->is_open ? OK : NOT_INITIALIZED;
#ifndef _WIN32
    if (c->is_open)
        close((int)c->event);
#endif
    if (c->has_socket)
        closesocket(c->socket);
    c->is_open = c->has_socket = 0;
    c->event = 0;
    /* What was set holds until the channel is closed. */
    c->listen_only = c->allow_status = c->allow_errors = 0;
    pthread_mutex_unlock(&lock);
    return status;
}

/* Why nothing can be done with a channel. */
static uint32_t trouble(uint16_t handle, Channel *c, int function) {
    if (!c || !condition(handle))
        return NO_HARDWARE;
    if (!c->is_open)
        return NOT_INITIALIZED;
    return c->answers[function];
}

EXPORT uint32_t CALL CAN_GetStatus(uint16_t handle) {
    Channel *c = channel(handle);
    pthread_mutex_lock(&lock);
    uint32_t status = trouble(handle, c, GET_STATUS);
    if (status == OK)
        status = c->bus | c->lost;
    pthread_mutex_unlock(&lock);
    return status;
}

EXPORT uint32_t CALL CAN_Read(uint16_t handle, Message *message, Stamp *stamp) {
    Channel *c = channel(handle);
    pthread_mutex_lock(&lock);
    uint32_t status = trouble(handle, c, READ);
    if (status == OK && !c->count) {
        status = EMPTY;
        sleep_again(c);
    } else if (status == OK) {
        uint64_t micros = c->times[c->first];
        *message = c->queue[c->first];
        *stamp = (Stamp){(uint32_t)(micros / 1000), (uint16_t)(micros / 1000 >> 32), (uint16_t)(micros % 1000)};
        c->first = (c->first + 1) % RECEIVE_QUEUE;
        c->count--;
        /* The message is valid; what was lost is told once. */
        status = c->lost;
        c->lost = 0;
    }
    pthread_mutex_unlock(&lock);
    return status;
}

EXPORT uint32_t CALL CAN_Write(uint16_t handle, Message *message) {
    Channel *c = channel(handle);
    pthread_mutex_lock(&lock);
    uint32_t status = trouble(handle, c, WRITE);
    if (status == OK && (message->length > 8 || message->id > (message->type & EXTENDED ? 0x1FFFFFFFu : 0x7FFu)))
        status = WRONG_VALUE;
    if (status == OK && c->waiting == TRANSMIT_QUEUE)
        status = QUEUE_FULL;
    if (status == OK) {
        c->waiting += c->holds != 0;
        c->sent[c->sent_count++ % SENT] = *message;
        if (c->has_socket)
            transmit(c, message);
        status = c->bus & BUSES;
    }
    pthread_mutex_unlock(&lock);
    return status;
}

EXPORT uint32_t CALL CAN_GetValue(uint16_t handle, uint8_t parameter, void *buffer, uint32_t length) {
    Channel *c = channel(handle);
    uint32_t number = 0;
    if (parameter == API_VERSION || parameter == HARDWARE_NAME) {
        if (parameter == HARDWARE_NAME && !condition(handle))
            return NO_HARDWARE;
        snprintf(buffer, length, "%s", parameter == API_VERSION ? "4.9.0.942" : "PCAN-USB");
        return OK;
    }
    if (length < sizeof number)
        return WRONG_VALUE;
    if (parameter == CONDITION)
        number = condition(handle);
#ifndef _WIN32
    else if (parameter == RECEIVE_EVENT && c && c->is_open)
        number = (uint32_t)c->event;
#endif
    else
        return c ? UNKNOWN_PARAMETER : NO_HARDWARE;
    memcpy(buffer, &number, sizeof number);
    return OK;
}

EXPORT uint32_t CALL CAN_SetValue(uint16_t handle, uint8_t parameter, void *buffer, uint32_t length) {
    Channel *c = channel(handle);
    uint32_t number = 0;
    if (!c)
        return NO_HARDWARE;
#ifdef _WIN32
    if (parameter == RECEIVE_EVENT) {
        if (!c->is_open)
            return NOT_INITIALIZED;
        memcpy(&c->event, buffer, sizeof c->event);
        return OK;
    }
#endif
    if (length < sizeof number)
        return WRONG_VALUE;
    memcpy(&number, buffer, sizeof number);
    /* This one may be set before the channel is opened. */
    if (parameter == LISTEN_ONLY)
        c->listen_only = number;
    else if (!c->is_open)
        return NOT_INITIALIZED;
    else if (parameter == ALLOW_STATUS)
        c->allow_status = number;
    else if (parameter == ALLOW_ERRORS)
        c->allow_errors = number;
    else if (parameter != BUS_OFF_RESET)
        return UNKNOWN_PARAMETER;
    return OK;
}

/* 0: not there, 1: there, 2: another program has it. */
EXPORT void stand_in_plug(uint16_t handle, uint32_t to) {
    channel(handle)->condition = to;
}

/* What a function answers from now on, whatever else would be true; 0: the truth. */
EXPORT void stand_in_answer(uint16_t handle, uint32_t function, uint32_t status) {
    channel(handle)->answers[function] = status;
}

/* The state of the bus, as bits of the status. */
EXPORT void stand_in_bus(uint16_t handle, uint32_t status) { channel(handle)->bus = status; }

/* Nothing leaves the transmit queue, or all does. */
EXPORT void stand_in_hold(uint16_t handle, uint32_t holds) {
    pthread_mutex_lock(&lock);
    channel(handle)->holds = (int)holds;
    if (!holds)
        channel(handle)->waiting = 0;
    pthread_mutex_unlock(&lock);
}

/* So many messages arrive one after the other, a millisecond apart, before anybody can fetch one. */
EXPORT void stand_in_receive(uint16_t handle, const Message *message, uint64_t micros, uint32_t times) {
    pthread_mutex_lock(&lock);
    for (uint32_t n = 0; n < times; n++)
        push(channel(handle), *message, micros + n * 1000);
    pthread_mutex_unlock(&lock);
}

/* How many were sent, and the one of that number. */
EXPORT uint32_t stand_in_sent(uint16_t handle, uint32_t number, Message *message) {
    pthread_mutex_lock(&lock);
    *message = channel(handle)->sent[number % SENT];
    uint32_t count = channel(handle)->sent_count;
    pthread_mutex_unlock(&lock);
    return count;
}

/* How the channel is open: the registers, whether it only listens, and how often it was opened; all ones if it is not. */
EXPORT uint32_t stand_in_open(uint16_t handle) {
    Channel *c = channel(handle);
    return c->is_open ? c->registers | (c->listen_only ? 1u << 16 : 0) | c->opened << 17 : UINT32_MAX;
}
