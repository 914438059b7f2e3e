// Motor402 of ros_canopen (https://github.com/ros-industrial/ros_canopen), unchanged, at a socketcand: it homes one
// CiA 402 drive, moves it in each of its modes, halts and recovers it.  What it saw goes out as lines.
//
//     drive 127.0.0.1:29569:can0 cia402-drive.eds 3 24 100      24: homing method, 0 for that of the drive; 100: 1017h

#include <arpa/inet.h>
#include <sys/socket.h>

#include <iostream>

#include <canopen_402/motor.h>
#include <canopen_master/can_layer.h>
#include <canopen_master/src/master_plugin.cpp>

using namespace canopen;

const int SYNC_MS = 10, STEPS = 100;
const boost::chrono::milliseconds POLL(10), LIMIT(8000);

// The raw mode of socketcand as a driver of ros_canopen: `< send 123 2 aa bb >` out, `< frame 123 23.42 aabb >` in.
class Socketcand : public can::DriverInterface {
public:
    bool init(const std::string &where, bool) override {
        std::istringstream parts(where);
        std::string host, port, bus;
        std::getline(std::getline(std::getline(parts, host, ':'), port, ':'), bus);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(std::stoi(port));
        inet_pton(AF_INET, host.c_str(), &address.sin_addr);
        socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
        std::string answer;
        if (::connect(socket_, (sockaddr *)&address, sizeof address) || !take(answer)) return false;
        for (const std::string &line : {"< open " + bus + " >", std::string("< rawmode >")})
            if (!put(line) || !take(answer)) return false;
        enter(can::State::open);
        return true;
    }
    bool init(const std::string &where, bool loopback, can::SettingsConstSharedPtr) override { return init(where, loopback); }
    bool recover() override { return false; }
    bool translateError(unsigned int, std::string &) override { return false; }
    bool doesLoopBack() const override { return false; }
    can::State getState() override { boost::mutex::scoped_lock lock(mutex_); return state_; }
    void shutdown() override { ::shutdown(socket_, SHUT_RDWR); enter(can::State::closed); }
    can::FrameListenerConstSharedPtr createMsgListener(const FrameFunc &call) override { return frames_.createListener(call); }
    can::FrameListenerConstSharedPtr createMsgListener(const can::Header &header, const FrameFunc &call) override {
        return frames_.createListener(header.key(), call);
    }
    can::StateListenerConstSharedPtr createStateListener(const StateFunc &call) override { return states_.createListener(call); }

    bool send(const can::Frame &frame) override {
        std::ostringstream line;
        line << "< send " << std::hex << frame.id << " " << int(frame.dlc);
        for (int i = 0; i < frame.dlc; ++i) line << " " << int(frame.data[i]);
        return put(line.str() + " >");
    }

    void run() override {
        enter(can::State::ready);
        for (std::string line; take(line);) {
            std::istringstream words(line);
            std::string kind, identifier, time, part, data;
            words >> kind >> identifier >> time;
            while (words >> part) data += part;
            if (kind != "frame") continue;
            can::Frame frame(can::MsgHeader(std::stoul(identifier, nullptr, 16)), data.size() / 2);
            for (size_t i = 0; i < data.size() / 2; ++i) frame.data[i] = std::stoul(data.substr(2 * i, 2), nullptr, 16);
            frames_.dispatch(frame.key(), frame);
        }
        enter(can::State::closed);
    }

private:
    can::FilteredDispatcher<unsigned int, can::CommInterface::FrameListener> frames_;
    can::SimpleDispatcher<can::StateInterface::StateListener> states_;
    can::State state_;
    boost::mutex mutex_;
    int socket_ = -1;
    std::string text_;

    void enter(can::State::DriverState state) {
        can::State now;
        {
            boost::mutex::scoped_lock lock(mutex_);
            state_.driver_state = state;
            now = state_;
        }
        states_.dispatch(now);
    }
    bool put(const std::string &line) { return ::send(socket_, line.data(), line.size(), MSG_NOSIGNAL) == ssize_t(line.size()); }
    bool take(std::string &line) {
        char bytes[4096];
        size_t end;
        while ((end = text_.find('>')) == std::string::npos) {
            ssize_t count = ::recv(socket_, bytes, sizeof bytes, 0);
            if (count <= 0) return false;
            text_.append(bytes, count);
        }
        size_t begin = text_.find('<') + 1;
        line = text_.substr(begin, end - begin);
        text_.erase(0, end + 1);
        return true;
    }
};

// What its users write into `dcf_overlay`: PDOs with each SYNC, that carry what the modes need.
ObjectDict::Overlay overlay(const std::string &method, const std::string &heartbeat_ms) {
    ObjectDict::Overlay entries{{"6081", "5000000"}, {"1017", heartbeat_ms}};
    if (method != "0") entries.push_back({"6098", method});
    auto pdo = [&](const char *number, const char *type, std::vector<const char *> objects) {
        std::string map = std::string("1") + number;
        for (size_t i = 0; i < objects.size(); ++i) entries.push_back({map + "sub" + std::to_string(i + 1), objects[i]});
        entries.push_back({map + "sub0", std::to_string(objects.size())});
        entries.push_back({std::string("1") + type + "sub2", "1"});
    };
    pdo("600", "400", {"0x60400010", "0x60600008"});
    pdo("601", "401", {"0x607A0020", "0x60FF0020"});
    pdo("602", "402", {"0x60420010", "0x60710010"});
    pdo("603", "403", {"0x60C10120"});
    pdo("A00", "800", {"0x60410010", "0x60610008"});
    pdo("A01", "801", {"0x60640020", "0x606C0020"});
    pdo("A02", "802", {"0x60770010", "0x60440010"});
    pdo("A03", "803", {"0x60630020"});
    return entries;
}

class Trial {
public:
    Trial(std::shared_ptr<Motor402> motor, ObjectStorageSharedPtr objects) : motor_(motor) {
        objects->entry(position_, 0x6064);
        objects->entry(speed_, 0x606C);
        objects->entry(torque_, 0x6077);
        objects->entry(motor_speed_, 0x6044);
    }
    void all_modes() {
        auto position = [&] { return double(position_.get()); };
        auto speed = [&] { return double(speed_.get()); };
        auto torque = [&] { return double(torque_.get()); };
        auto motor_speed = [&] { return double(motor_speed_.get()); };
        mode(MotorBase::Profiled_Position, position, {2000000, -1000000}, 200);
        mode(MotorBase::Velocity, motor_speed, {120, 0}, 2);
        mode(MotorBase::Profiled_Velocity, speed, {1500000, 0}, 50000);
        mode(MotorBase::Profiled_Torque, torque, {50, 0}, 5);
        follow(MotorBase::Interpolated_Position, 1000000);
        follow(MotorBase::Cyclic_Synchronous_Position, -1000000);
        mode(MotorBase::Cyclic_Synchronous_Velocity, speed, {-800000, 0}, 50000);
        mode(MotorBase::Cyclic_Synchronous_Torque, torque, {-40, 0}, 5);
    }

private:
    std::shared_ptr<Motor402> motor_;
    ObjectStorage::Entry<int32_t> position_, speed_;
    ObjectStorage::Entry<int16_t> torque_, motor_speed_;

    bool reaches(const std::function<double()> &value, double target, double tolerance) {
        int times = 0;
        for (auto end = get_abs_time(LIMIT); times < 5 && get_abs_time() < end; boost::this_thread::sleep_for(POLL))
            times = std::abs(value() - target) <= tolerance ? times + 1 : 0;
        return times == 5;
    }
    void mode(int mode, const std::function<double()> &value, std::vector<double> targets, double tolerance) {
        bool moves = motor_->enterModeAndWait(mode);
        for (double target : targets) moves = moves && motor_->setTarget(target) && reaches(value, target, tolerance);
        std::cout << "mode " << mode << ": " << (moves ? "moves" : "fails") << std::endl;
    }
    void follow(int mode, double distance) {
        bool moves = motor_->enterModeAndWait(mode);
        double begin = position_.get();
        for (int step = 1; moves && step <= STEPS; ++step) {
            moves = motor_->setTarget(begin + distance * step / STEPS);
            boost::this_thread::sleep_for(boost::chrono::milliseconds(SYNC_MS));
        }
        moves = moves && reaches([&] { return double(position_.get()); }, begin + distance, 2000);
        std::cout << "mode " << mode << ": " << (moves ? "moves" : "fails") << std::endl;
    }
};

int main(int, char **argv) {
    auto dictionary = ObjectDict::fromFile(argv[2], overlay(argv[4], argv[5]));
    auto driver = std::make_shared<Socketcand>();
    auto sync = SimpleMaster::Allocator().allocate("master", driver)->getSync(SyncProperties(can::MsgHeader(0x80), SYNC_MS, 0));
    auto node = std::make_shared<Node>(driver, dictionary, std::stoi(argv[3]), sync);
    auto motor = std::make_shared<Motor402>("drive", node->getStorage(), *can::SettingsMap::create());
    motor->registerDefaultModes(node->getStorage());
    LayerStack stack("drive");
    stack.add(std::make_shared<CANLayer>(driver, argv[1], false, can::NoSettings::create()));
    stack.add(sync);
    stack.add(node);
    stack.add(motor);
    std::atomic<bool> is_running(true);
    boost::thread cycles([&] {
        for (; is_running; boost::this_thread::sleep_for(boost::chrono::milliseconds(1))) {
            LayerStatus status;
            stack.read(status);
            stack.write(status);
        }
    });
    LayerStatus init;
    stack.init(init);
    std::cout << "init: " << (init.bounded<LayerStatus::Warn>() ? "ready" : init.reason()) << std::endl;
    if (init.bounded<LayerStatus::Warn>()) {
        Trial(motor, node->getStorage()).all_modes();
        LayerStatus halt, recover;
        LayerReport halted, recovered;
        stack.halt(halt);
        boost::this_thread::sleep_for(boost::chrono::milliseconds(500));
        motor->diag(halted);
        stack.recover(recover);
        motor->diag(recovered);
        std::cout << "halt: " << halted.reason() << std::endl << "recover: " << recover.reason() << recovered.reason() << std::endl;
    }
    LayerStatus shutdown;
    stack.shutdown(shutdown);
    is_running = false;
    cycles.join();
}
