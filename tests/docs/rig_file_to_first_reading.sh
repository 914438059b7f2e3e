# The path of docs/begin/begin.md from an empty rig file to the first reading.  The files of the page are in this folder.
export FIELDRIG_CONTROL=tcp/127.0.0.1:7449
fieldrig check meter.yaml | grep "^meter.yaml has no mistakes"
fieldrig up meter.yaml --quiet &
until fieldrig status --ready all 2> waiting; do kill -0 $!; sleep 0.5; done
fieldrig get meter/voltage | grep -x "meter/voltage = 230.5 V"
fieldrig set meter/voltage=229.5
python -c "from pymodbus.client import ModbusTcpClient as M; print(M('127.0.0.1', port=5021).read_input_registers(0))" \
  | grep "registers=\[2295\]"
fieldrig stop
wait $!
