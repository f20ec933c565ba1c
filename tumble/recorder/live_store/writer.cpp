#include "tumble/recorder/live_store/writer.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "tumble/units/error.hpp"

namespace tumble::live_store {

namespace fs = std::filesystem;

namespace {

std::string store_path(const std::string& folder) { return (fs::path(folder) / live_store_name).string(); }
std::string reserve_path(const std::string& folder) { return (fs::path(folder) / reserve_name).string(); }

/// 0: there is no such file.
std::uint64_t inode_of(const std::string& path) {
  struct stat state {};
  return stat(path.c_str(), &state) == 0 ? static_cast<std::uint64_t>(state.st_ino) : 0;
}

[[noreturn]] void refuse_store(const std::string& path, const Refusal& refusal) {
  if (refusal.busy())
    throw Error(Error::Kind::bad_file,
                say("'{}' is being recorded by another process: one process writes a store", path));
  throw Error(Error::Kind::bad_file, say("cannot record into '{}': {}", path, system_reason(refusal.text)));
}

void check_place(const std::string& folder, const Disk& disk, const RecorderOptions& options) {
  const std::string path = store_path(folder);
  if (!fs::is_directory(folder))
    throw Error(Error::Kind::bad_file, say("cannot record into '{}': there is no such folder", folder));
  if (fs::exists(path) && !options.resume)
    throw Error(Error::Kind::bad_file,
                say("'{}' holds a recording already; `tumble seal {}` makes a file of it", path, Name{folder}));
  const std::uint64_t room = disk.room(folder), needed = options.reserve_bytes + options.floor_bytes;
  if (room < needed)
    throw Error(Error::Kind::bad_file,
                say("the disk under '{}' has room for {:.0f} MB; a recording begins with at least {:.0f} MB", folder,
                    static_cast<double>(room) * 1e-6, static_cast<double>(needed) * 1e-6));
}

/// The store of a folder, and its name there for certain.
StoreFile opened_store(const std::string& folder, Disk& disk, const RecorderOptions& options) {
  check_place(folder, disk, options);
  const std::string path = store_path(folder);
  try {
    if (options.reserve_bytes > 0) disk.allocate(reserve_path(folder), options.reserve_bytes);
    StoreFile store(path, disk.vfs(),
                    options.resume && fs::exists(path) ? Database::Mode::existing : Database::Mode::create);
    store.bring_up_to_date();
    disk.synchronise_folder(folder);
    return store;
  } catch (const Refusal& refusal) {
    refuse_store(path, refusal);
  }
}

}  // namespace

Writer::Writer(std::string folder, Disk& disk, const RecorderOptions& options)
    : folder_(std::move(folder)),
      disk_(disk),
      options_(options),
      store_(opened_store(folder_, disk, options)),
      front_(store_->state(), options),
      acknowledged_{store_->state().last, store_->state().time} {
  inode_ = inode_of(store_path(folder_));
  if (options_.background) thread_ = std::thread([this] { work(); });
}

Writer::~Writer() {
  flush();
  end_thread();
  if (disk_.failed() && store_) store_->keep_log();
}

void Writer::end_thread() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Writer::fail(StoreFailure::Kind kind, Sentence text) {
  if (!failure_) failure_ = StoreFailure{kind, std::move(text)};
}

/// More waits than may: the disk is too slow. What waits is written still, what comes is refused.
void Writer::look_for_overflow() {
  if (failure_ || front_.bytes() <= options_.queue_bytes) return;
  fail(StoreFailure::Kind::overflow,
       say("the disk is too slow: {:.0f} MB waited to be written, and the recording was stopped; everything "
           "up to then is kept",
           static_cast<double>(front_.bytes()) * 1e-6));
  front_.event({front_.time(), EventKind::stopped, {}, failure_->text, {}});
}

void Writer::hold() {
  const std::lock_guard lock(mutex_);
  ++holds_;
}

void Writer::release() {
  {
    const std::lock_guard lock(mutex_);
    if (--holds_ > 0) return;
    look_for_overflow();
  }
  whole_.notify_all();
}

void Writer::wait_for_wholes(std::unique_lock<std::mutex>& lock) {
  whole_.wait(lock, [this] { return holds_ == 0; });
}

void Writer::work() {
  std::unique_lock lock(mutex_);
  const auto begun = [this] { return stopping_ || asked_ > answered_ || !front_.empty(); };
  const auto now = [this] { return stopping_ || asked_ > answered_ || front_.urgent(); };
  for (;;) {
    changed_.wait(lock, begun);
    changed_.wait_for(lock, std::chrono::duration<double>(options_.commit_after), now);
    wait_for_wholes(lock);
    if (stopping_ && front_.empty()) return;
    commit_one(lock);
  }
}

void Writer::commit_one(std::unique_lock<std::mutex>& lock) {
  const std::uint64_t asked = asked_;
  Batch batch = front_.take();
  if (!batch.empty() && !disk_.failed()) {
    try {
      if (try_write(batch, lock)) tidy(lock);
      look_for_store();
    } catch (const Refusal& refusal) {
      handle(refusal, std::move(batch), lock);
    }
  }
  report_failure(lock);
  answered_ = asked;
  written_.notify_all();
}

bool Writer::try_write(const Batch& batch, std::unique_lock<std::mutex>& lock) {
  lock.unlock();
  const double begin = options_.clock ? options_.clock() : 0.0;
  try {
    store_->write(batch);
  } catch (const Refusal&) {
    lock.lock();
    throw;
  }
  const double took = options_.clock ? options_.clock() - begin : 0.0;
  const Acknowledged acknowledged{batch.last, batch.time};
  if (options_.on_commit) options_.on_commit(acknowledged);
  lock.lock();
  acknowledged_ = acknowledged;
  ++load_.commits;
  load_.longest_commit = std::max(load_.longest_commit, took);
  return true;
}

/// What is written into a file that has no name any more is lost when it is closed.
void Writer::look_for_store() {
  if (failure_) return;
  const auto is_there = [](const std::string& path, std::uint64_t& known) {
    const std::uint64_t now = inode_of(path);
    if (known == 0) known = now;
    return now == known;
  };
  const std::string path = store_path(folder_);
  const bool store = is_there(path, inode_);
  if (store && is_there(path + "-wal", log_inode_)) return;
  fail(StoreFailure::Kind::disk, say("'{}' was removed or replaced while it was written, and the recording was "
                                     "stopped: what was recorded may be lost",
                                     store ? path + "-wal" : path));
}

/// A full disk: the reserve is given up for what waits and the end record. Any other error: nothing more is written,
/// because a disk that has failed once cannot be believed.
void Writer::handle(const Refusal& refusal, Batch batch, std::unique_lock<std::mutex>& lock) {
  wait_for_wholes(lock);
  if (refusal.input_output()) disk_.note_failure();
  if (!refusal.full() || disk_.failed()) {
    fail(StoreFailure::Kind::disk,
         say("the disk under '{}' failed ({}), and the recording was stopped; everything that was acknowledged "
             "is kept",
             folder_, system_reason(refusal.text)));
    return;
  }
  fail(StoreFailure::Kind::full,
       say("the disk under '{}' is full, and the recording was stopped; everything that was acknowledged is "
           "kept",
           folder_));
  front_.put_back(std::move(batch));
  front_.event({front_.time(), EventKind::stopped, {}, failure_->text, {}});
  const Batch last = front_.take();
  try {
    lock.unlock();  // who appends does not wait for the disk
    disk_.remove(reserve_path(folder_));
    lock.lock();
    try_write(last, lock);
  } catch (const Refusal&) {
  } catch (const Error&) {
  }
  if (!lock.owns_lock()) lock.lock();
}

void Writer::report_failure(std::unique_lock<std::mutex>& lock) {
  if (!failure_ || reported_) return;
  reported_ = true;
  if (!options_.on_failure) return;
  const StoreFailure failure = *failure_;
  lock.unlock();
  options_.on_failure(failure);
  lock.lock();
}

/// After a commit: the log is copied back where it has grown, and the room looked at.
void Writer::tidy(std::unique_lock<std::mutex>& lock) {
  if (store_->since_checkpoint() < options_.checkpoint_bytes) return;
  lock.unlock();
  std::optional<Refusal> refusal;
  bool low = false;
  try {
    store_->checkpoint();
    low = disk_.room(folder_) < options_.floor_bytes;
  } catch (const Refusal& refused) {
    refusal = refused;
  } catch (const Error& error) {
    refusal = Refusal{0, error.what()};
  }
  lock.lock();
  if (low && !refusal) {
    fail(StoreFailure::Kind::full,
         say("less than {:.0f} MB of room are left under '{}', and the recording was stopped; everything "
             "is kept",
             static_cast<double>(options_.floor_bytes) * 1e-6, folder_));
    front_.event({front_.time(), EventKind::stopped, {}, failure_->text, {}});
  }
  if (refusal) handle(*refusal, {}, lock);
}

bool Writer::flush(double within) {
  std::unique_lock lock(mutex_);
  if (!options_.background) {
    while (!front_.empty() && !disk_.failed()) commit_one(lock);
    report_failure(lock);
    return !failure_;
  }
  const std::uint64_t mine = ++asked_;
  changed_.notify_all();
  const auto answered = [&] { return answered_ >= mine || stopping_; };
  if (std::isfinite(within))
    return written_.wait_for(lock, std::chrono::duration<double>(within), answered) && !failure_;
  written_.wait(lock, answered);
  return !failure_;
}

Acknowledged Writer::acknowledged() const {
  const std::lock_guard lock(mutex_);
  return acknowledged_;
}

std::optional<StoreFailure> Writer::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

StoreLoad Writer::load() const {
  const std::lock_guard lock(mutex_);
  StoreLoad load = load_;
  load.items = front_.items();
  load.bytes = front_.all_bytes();
  return load;
}

bool Writer::close(double time, const Sentence& ending) {
  append([&](Front& front) { return front.event({time, EventKind::end, {}, ending, {}}); });
  const bool good = flush();
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return good;
    closed_ = true;
  }
  end_thread();
  if (disk_.failed()) return false;
  try {
    store_->checkpoint();
    store_.reset();
    disk_.remove(reserve_path(folder_));
    disk_.synchronise_folder(folder_);
  } catch (const Refusal& refusal) {  // everything is in the log still
    if (refusal.input_output()) disk_.note_failure();
  } catch (const Error&) {
  }
  return good;
}

}  // namespace tumble::live_store
