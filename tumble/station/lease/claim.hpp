#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tumble::lease {

/// Who has claimed a name, or had it and did not give it back.
struct Holder {
  long process = 0;  ///< 0: not known, or not to be believed
  std::string run;   ///< folder, absolute; empty: not known
};

/// The right to a name on this machine. A socket of the kernel has the name, which nobody can remove and which ends
/// with the process; it is the same for all users and for any TMPDIR. Files beside it say who has it and who had it:
/// /run/lock/tumble-leases, /var/tmp/tumble-leases. Where a container has its own names of sockets, and shares a folder
/// of the files, their locks exclude as well.
class Claim {
 public:
  explicit Claim(std::string name);
  Claim(Claim&& other) noexcept;
  Claim& operator=(Claim&&) = delete;
  ~Claim();

  bool holds() const { return socket_ >= 0; }       ///< else somebody else has it
  const Holder& before() const { return before_; }  ///< of a run that has it, or that did not give it back
  /// Who has it from now on. Throws Error::bad_file where no file can be written.
  void note(const std::string& content);
  /// Nothing is left. Where a file cannot be written, the next run takes over what is safe already.
  void give_back();

 private:
  void give_up();

  std::string name_;
  int socket_ = -1;
  std::vector<int> files_;
  Holder before_;
};

/// Whose claims hold on this machine, each once; what a file says of another user is believed, of this user it is
/// compared with what the kernel says.
std::vector<Holder> holders();

}  // namespace tumble::lease
