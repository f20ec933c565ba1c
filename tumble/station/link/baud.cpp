// Rates of serial lines that are in no list, such as the 374400 baud of an instrument: termios2 of Linux, whose header
// does not go together with <termios.h>.

#include "tumble/station/link/baud.hpp"

#include <asm/termbits.h>
#include <sys/file.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace tumble::link {

namespace {

std::string system_reason() { return std::system_category().message(errno); }

void set_framing(struct termios2& line, const std::string& framing) {
  if (framing.empty()) return;
  constexpr tcflag_t sizes[] = {CS5, CS6, CS7, CS8};
  line.c_cflag &= ~static_cast<tcflag_t>(CSIZE | PARENB | PARODD | CSTOPB);
  line.c_cflag |= sizes[framing[0] - '5'];
  if (framing[1] != 'N') line.c_cflag |= PARENB;
  if (framing[1] == 'O') line.c_cflag |= PARODD;
  if (framing[2] == '2') line.c_cflag |= CSTOPB;
}

}  // namespace

std::string set_line(int descriptor, long baud, const std::string& framing) {
  struct termios2 line {};
  if (ioctl(descriptor, TCGETS2, &line) != 0) return system_reason();
  line.c_iflag &=
      ~static_cast<tcflag_t>(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR | ICRNL | IXON | IXOFF | IXANY);
  line.c_oflag &= ~static_cast<tcflag_t>(OPOST);
  line.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS);
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  set_framing(line, framing);
  if (baud > 0) {
    line.c_cflag &= ~static_cast<tcflag_t>(CBAUD | (CBAUD << IBSHIFT));
    line.c_cflag |= BOTHER | (BOTHER << IBSHIFT);
    line.c_ispeed = line.c_ospeed = static_cast<speed_t>(baud);
  }
  if (ioctl(descriptor, TCSETS2, &line) != 0) return system_reason();
  if (ioctl(descriptor, TCGETS2, &line) != 0) return system_reason();
  const long set = static_cast<long>(line.c_ospeed);
  if (baud > 0 && labs(set - baud) * 50 > baud) return "the device runs at " + std::to_string(set) + " baud instead";
  ioctl(descriptor, TCFLSH, TCIFLUSH);
  return "";
}

std::string take_alone(int descriptor) {
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return "";
  return errno == EWOULDBLOCK ? "another program is using it" : system_reason();
}

}  // namespace tumble::link
