# The path of docs/begin/begin.md from a device of one's own to its first frame.  The files of the page are in this folder.
export FIELDRIG_CONTROL=tcp/127.0.0.1:7449
fieldrig devices lamp:Lamp | grep "^device lamp:Lamp: a lamp on CAN"
fieldrig check lamp.yaml | grep "^lamp.yaml has no mistakes"
fieldrig up lamp.yaml --quiet &
until fieldrig status --ready all 2> waiting; do kill -0 $!; sleep 0.5; done
fieldrig watch can0 -n 1 | grep "lamp  *181 \[1\] 00"
python -c "import can; b = can.Bus('can0', 'socketcand', host='127.0.0.1', port=29538); print(b.recv(5)); b.shutdown()" \
  | grep "ID: *181 .* DL: *1 *00"
python -c "import can; b = can.Bus('can0', 'socketcand', host='127.0.0.1', port=29538); b.send(can.Message(arbitration_id=0x201, data=[1], is_extended_id=False)); b.shutdown()"
until fieldrig get lamp/on | grep -x "lamp/on = true"; do kill -0 $!; done
fieldrig stop
wait $!
