#include "tumble/station/link.hpp"

#include <gtest/gtest.h>
#include <malloc.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#include "tumble/units/testing/asserts.hpp"

namespace tumble {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What happens on both sides until `count` bytes came on `link`, or the link is lost.
std::string received_by(Links& links, std::size_t link, std::size_t count) {
  std::string bytes;
  const double until = steady_seconds() + 20.0;
  while (bytes.size() < count && steady_seconds() < until)
    for (const LinkEvent& event : links.wait(0.1)) {
      if (event.link != link) continue;
      if (event.kind == LinkEvent::Kind::lost) return bytes + "|" + event.reason.text();
      bytes += event.bytes;
    }
  return bytes;
}

std::size_t came_in(Links& links) {
  const double until = steady_seconds() + 20.0;
  while (steady_seconds() < until)
    for (const LinkEvent& event : links.wait(0.1))
      if (event.kind == LinkEvent::Kind::up) return event.link;
  return static_cast<std::size_t>(-1);
}

LinkAddress port_here(std::uint16_t port) { return {.host = "127.0.0.1", .port = port}; }

TEST(LinkAddress, IsReadInEveryForm) {
  const LinkAddress tcp = parse_link("tcp:table.local:9878");
  EXPECT_EQ(tcp.host, "table.local");
  EXPECT_EQ(tcp.port, 9878);
  EXPECT_EQ(parse_link("tcp:[::1]:23").host, "::1");
  const LinkAddress serial = parse_link("serial:/dev/ttyUSB0:921600:8O1");
  EXPECT_EQ(serial.device, "/dev/ttyUSB0");
  EXPECT_EQ(serial.baud, 921600);
  EXPECT_EQ(serial.framing, "8O1");
  EXPECT_EQ(parse_link("serial:/dev/ttyS0").baud, 0);
  EXPECT_EQ(parse_link("serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:3:1.0-port0:9600").device,
            "/dev/serial/by-path/pci-0000:00:14.0-usb-0:3:1.0-port0");
  EXPECT_EQ(parse_link("udp:10.0.0.7:9000").host, "10.0.0.7");
  EXPECT_EQ(parse_link("udp:9000").host, "");
  for (const char* text : {"tcp:[::1]:23", "tcp:a:1", "udp:a:1", "udp:[::1]:2", "udp:3", "serial:/dev/x",
                           "serial:/dev/x:9600", "serial:/dev/x:9600:7E2"})
    EXPECT_EQ(text_of(parse_link(text)), text);
}

TEST(LinkAddress, RefusesOtherTextsWithTheFormsThatItAccepts) {
  for (const char* text :
       {"", "http:a:1", "udp:", "udp:0", "udp::5", "udp:host", "tcp:", "tcp:host", "tcp:host:0", "tcp:host:99999",
        "tcp::5", "serial:", "serial:/dev/x:1", "serial:/dev/x:9600:9X1", "tcp:host:12a"})
    EXPECT_TRUE(refuses(Error::Kind::bad_input,
                        std::vector<Asked>{{.values = {text}}, {.pattern = "a link is written tcp:HOST:PORT, udp:"}},
                        [&] { parse_link(text); }))
        << text;
}

TEST(Link, CarriesBytesBothWaysOverTcpAndStampsThem) {
  double now = 12.5;
  Links links([&] { return now; });
  const std::size_t client = links.open(port_here(links.listen(0)));
  const std::size_t server = came_in(links);
  links.send(client, "hello ");
  links.send(client, "there");
  EXPECT_EQ(received_by(links, server, 11), "hello there");
  const std::string much(3'000'000, 'x');
  links.send(server, much);
  EXPECT_EQ(received_by(links, client, much.size()), much);
  now = 13.5;
  links.send(client, "x");
  EXPECT_EQ(links.wait(10.0).at(0).time, 13.5);
}

TEST(Link, SaysAtWhichDoorTheOtherSideCameIn) {
  Links links(steady_seconds);
  const std::uint16_t first = links.listen(0), second = links.listen(0);
  ASSERT_NE(first, second);
  for (const std::uint16_t port : {second, first}) {
    links.open(port_here(port));
    std::vector<LinkEvent> events;
    while (events.empty()) events = links.wait(1.0);
    ASSERT_EQ(events.at(0).kind, LinkEvent::Kind::up);
    EXPECT_EQ(events.at(0).port, port);
  }
}

TEST(Link, ReportsACloseAfterTheBytesBeforeIt) {
  Links links(steady_seconds);
  const std::size_t client = links.open(port_here(links.listen(0)));
  const std::size_t server = came_in(links);
  links.send(server, "last words");
  EXPECT_EQ(received_by(links, client, 10), "last words");
  links.close(server);
  EXPECT_EQ(received_by(links, client, 1), "|the other side closed the link");
  EXPECT_FALSE(links.is_up(client));
  links.send(client, "nobody hears this");
}

/// A socket that is none of ours, at a free port of this machine.
struct OtherSocket {
  explicit OtherSocket(int type) : descriptor(socket(AF_INET, type, 0)) {
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(descriptor, reinterpret_cast<sockaddr*>(&address), size), 0);
    getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
  }
  ~OtherSocket() { close(descriptor); }
  std::uint16_t port() const { return ntohs(address.sin_port); }

  sockaddr_in address{};
  socklen_t size = sizeof address;
  int descriptor;
};

TEST(Link, ExchangesDatagrams) {
  OtherSocket device(SOCK_DGRAM);
  Links links(steady_seconds);
  const std::size_t link = links.open({.kind = LinkAddress::Kind::udp, .host = "127.0.0.1", .port = device.port()});
  links.send(link, "start");
  links.wait(0.01);
  char heard[16];
  const auto count =
      recvfrom(device.descriptor, heard, sizeof heard, 0, reinterpret_cast<sockaddr*>(&device.address), &device.size);
  ASSERT_EQ(std::string(heard, static_cast<std::size_t>(count)), "start");
  for (const std::string text : {"frame 1", "", "frame 2"})  // an empty one is no end
    ASSERT_GE(sendto(device.descriptor, text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&device.address),
                     device.size),
              0);
  EXPECT_EQ(received_by(links, link, 14), "frame 1frame 2");
  EXPECT_TRUE(links.is_up(link));
}

TEST(Link, ListensForDatagramsOfAnybody) {
  std::uint16_t port = 0;
  { port = OtherSocket(SOCK_DGRAM).port(); }
  Links links(steady_seconds);
  const std::size_t link = links.open({.kind = LinkAddress::Kind::udp, .port = port}, 5.0, 0.2);
  links.send(link, "nobody hears this");
  for (const std::string text : {"one ", "two"}) {
    OtherSocket device(SOCK_DGRAM);
    device.address.sin_port = htons(port);
    ASSERT_GT(sendto(device.descriptor, text.data(), text.size(), 0, reinterpret_cast<sockaddr*>(&device.address),
                     device.size),
              0);
  }
  EXPECT_EQ(received_by(links, link, 7), "one two");
  EXPECT_EQ(received_by(links, link, 1), "|nothing was received for 0.2 s");
}

/// A device that accepts and hangs up again and again for days.
TEST(Link, KeepsNothingOfLinksThatHaveEnded) {
  Links links(steady_seconds);
  const std::uint16_t port = links.listen(0);
  const auto in_use = [] { return mallinfo2().uordblks + mallinfo2().hblkhd; };
  std::size_t before = 0;
  for (int i = 0; i < 300; ++i) {
    const std::size_t mine = links.open(port_here(port), 5.0), other = came_in(links);
    links.send(mine, "hello");
    ASSERT_EQ(received_by(links, other, 5), "hello");
    links.close(other);
    EXPECT_EQ(received_by(links, mine, 1).substr(0, 1), "|");
    if (i == 50) before = in_use();
  }
  EXPECT_LT(in_use(), before + 1000000);  // 250 links of 64 kB, twice, would be 32 MB
}

TEST(Link, ReportsABreak) {
  OtherSocket listening(SOCK_STREAM);
  const int door = listening.descriptor;
  ASSERT_EQ(listen(door, 1), 0);
  Links links(steady_seconds);
  const std::size_t client = links.open(port_here(listening.port()));
  const int other = accept(door, nullptr, nullptr);
  const linger at_once{1, 0};  // an RST in place of an orderly end
  setsockopt(other, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  close(other);
  EXPECT_EQ(received_by(links, client, 1), "|the other side broke the link off");
}

TEST(Link, CountsAsLostWhenItIsSilent) {
  Links links(steady_seconds);
  const std::size_t client = links.open(port_here(links.listen(0)), 5.0, 0.2);
  const std::size_t server = came_in(links);
  for (int i = 0; i < 4; ++i) {
    links.send(server, "x");
    EXPECT_EQ(received_by(links, client, 1), "x");
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const double begin = steady_seconds();
  EXPECT_EQ(received_by(links, client, 1), "|nothing was received for 0.2 s");
  EXPECT_GT(steady_seconds() - begin, 0.15);
}

TEST(Link, SaysWhatIsMissing) {
  Links links(steady_seconds);
  std::uint16_t closed = 0;
  {
    Links other(steady_seconds);
    closed = other.listen(0);
  }
  const auto file = Error::Kind::bad_file;
  EXPECT_TRUE(refuses(file, Asked{.values = {text_of(port_here(closed))}, .pattern = "nothing listens at this port"},
                      [&] { links.open(port_here(closed)); }));
  EXPECT_TRUE(refuses(file, Asked{.values = {"/dev/no-such-line"}, .pattern = "there is no serial device"},
                      [&] { links.open(parse_link("serial:/dev/no-such-line:9600")); }));
  EXPECT_TRUE(refuses(file, Asked{.values = {"/dev/null"}, .pattern = "is not a serial device"},
                      [&] { links.open(parse_link("serial:/dev/null")); }));
}

TEST(Link, CarriesBytesOverASerialLine) {
  Links links(steady_seconds);
  const auto terminal = links.open_terminal();
  const std::size_t line = links.open(parse_link("serial:" + terminal.device + ":374400:8N1"));
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes += static_cast<char>(i);  // no byte means anything to the line
  links.send(terminal.link, bytes);
  EXPECT_EQ(received_by(links, line, bytes.size()), bytes);
  links.send(line, bytes);
  EXPECT_EQ(received_by(links, terminal.link, bytes.size()), bytes);
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{.values = {terminal.device}, .part = "another program"},
                      [&] { links.open(parse_link("serial:" + terminal.device)); }));
}

TEST(Link, ReportsAnUnpluggedSerialLine) {
  Links far(steady_seconds), links(steady_seconds);
  const auto terminal = far.open_terminal();
  const std::size_t line = links.open(parse_link("serial:" + terminal.device + ":9600"));
  far.close(terminal.link);
  const std::string end = received_by(links, line, 1);
  EXPECT_TRUE(end == "|the device was unplugged or its other side was closed" ||
              end == "|the other side closed the link")
      << end;
}

TEST(Link, WaitsUntilItIsWoken) {
  Links links(steady_seconds);
  const double begin = steady_seconds();
  EXPECT_TRUE(links.wait(0.05).empty());
  EXPECT_GT(steady_seconds() - begin, 0.04);
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    links.wake();
  });
  EXPECT_TRUE(links.wait(100.0).empty());
  other.join();
  EXPECT_LT(steady_seconds() - begin, 50.0);
}

TEST(LinkTcp, ThePeerOfANameIsANumber) {
  Links links(steady_seconds);
  const auto port = links.listen(0);
  const auto link = links.open(parse_link("tcp:localhost:" + std::to_string(port)));
  EXPECT_EQ(links.peer(link), "127.0.0.1");
  links.close(link);
  EXPECT_EQ(links.peer(link), "");
}

/// What arrives while this process is stopped is there when it goes on, although the time of the wait is over.
TEST(Link, AWaitThatWasOversleptGivesWhatHasArrived) {
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t process = fork();
  if (process == 0) {
    Links links(steady_seconds);
    const std::uint16_t port = links.listen(0);
    if (write(ready[1], &port, sizeof port) != sizeof port) _exit(2);
    const std::size_t link = came_in(links);
    if (write(ready[1], &port, sizeof port) != sizeof port) _exit(3);
    for (const LinkEvent& event : links.wait(0.6))
      if (event.link == link && event.bytes == "now") _exit(0);
    _exit(1);
  }
  std::uint16_t port = 0;
  ASSERT_EQ(read(ready[0], &port, sizeof port), static_cast<ssize_t>(sizeof port));
  const int client = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(read(ready[0], &port, sizeof port), static_cast<ssize_t>(sizeof port));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  kill(process, SIGSTOP);
  EXPECT_EQ(write(client, "now", 3), 3);
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));
  kill(process, SIGCONT);
  int status = 0;
  ASSERT_EQ(waitpid(process, &status, 0), process);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  for (const int file : {client, ready[0], ready[1]}) close(file);
}

/// A server that runs out of file handles goes on to serve those that are connected, and takes the next one in later.
TEST(Link, ADoorWaitsForAFileHandle) {
  Links links(steady_seconds);
  const std::uint16_t port = links.listen(0);
  const int client = socket(AF_INET, SOCK_STREAM, 0);
  ASSERT_GE(client, 0);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const int next = dup(client);
  close(next);
  rlimit none = before;
  none.rlim_cur = static_cast<rlim_t>(next);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int connected = connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const bool nothing = links.wait(0.3).empty();
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(connected, 0);
  EXPECT_TRUE(nothing);
  EXPECT_NE(came_in(links), static_cast<std::size_t>(-1));
  close(client);
}

/// However fast one sends, what a wait gives has a bound, and another link has its part of it.
TEST(Link, AFloodOfOneLinkLeavesTheOthersTheirs) {
  Links links(steady_seconds), others(steady_seconds);
  const auto port = others.listen(0);
  const auto flooded = links.open(port_here(port));
  const auto flooder = came_in(others);
  const auto quiet = links.open(port_here(port));
  const auto speaker = came_in(others);
  std::atomic<bool> ended{false};
  std::thread sender([&] {
    const std::string lines(std::size_t{1} << 16, 'x');
    while (!ended) {
      if (others.unsent(flooder) < 8 * lines.size()) others.send(flooder, lines);
      others.wait(0.0);
    }
  });
  std::size_t most = 0, all = 0;
  for (int i = 0; i < 200; ++i) {
    std::size_t now = 0;
    for (const LinkEvent& event : links.wait(1.0)) now += event.link == flooded ? event.bytes.size() : 0;
    most = std::max(most, now);
    all += now;
  }
  ended = true;
  sender.join();
  EXPECT_LT(most, std::size_t{1} << 17);
  EXPECT_GT(all, most);
  others.send(speaker, "here");
  for (int i = 0; i < 10; ++i) others.wait(0.0);
  std::string heard;
  int waits = 0;
  for (; heard.empty() && waits < 50; ++waits)
    for (const LinkEvent& event : links.wait(1.0))
      if (event.link == quiet) heard += event.bytes;
  EXPECT_EQ(heard, "here");
}

}  // namespace
}  // namespace tumble
