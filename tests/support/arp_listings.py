"""The three complete programs of the manual (5.13), with the marks of its text removed."""

EXEMPLE1 = """\
beg EXEMPLE1

@par1[4] == 0
@par2[4] == 0

cam1 1, 5000, 15000, O101
cam2 1, 15000, 5000, O102
V10 == 5000

on3 F2 & (1 > V10) INTER
on6 F3 & /F4    INTER2

LOOP:
  V1 == @POS1

  goto LOOP
end

bega INTER
res F2
set O103
enda

bega INTER2
res F3
set O104
enda
"""

EXAMPLE2 = """\
beg EXAMPLE2

@par2[4] == 1      ; simulated Master axis
@par1[4] == 2      ; controlled Slave axis

wait 1
V[10] == 3
V[11] == 0
V[12] == 0
V[13] == 5000
V[14] == 5000
V[15] == 10000
V[16] == 0

pst 2,1,V10
WSYNC:
if F261=lo, WSYNC

LOOP:
if F292=lo, LOOP
wait 1
pac 2, 10000
W2:
if F292=lo, W2
wait 1
pac 2, 0

goto LOOP

end
"""

TEST_PID = """\
REFPID      equ    V50
SGLOFF      equ    V51
DELTAR      equ    V52
OFFREF      equ    V53
KMIS        equ    V54
OFFMIS      equ    V55
KFF         equ    V56
KERR        equ    V57
MAXERR      equ    V58
MAXPID      equ    V59
MINPID      equ    V60
KREG        equ    V61
KOUT        equ    V62
MAXDAC      equ    V63
MINDAC      equ    V64
OFFDAC      equ    V65
SWCVEL      equ    V66
KVEL        equ    V67
DG_MIS      equ    V68
DG_REF      equ    V69
DG_ERR      equ    V70
DG_PID      equ    V71
DG_OUT      equ    V72
DG_VEL      equ    V73
DG_DAC      equ    V74

F_START     equ    F303
F_STOP      equ    F304
F_RESET     equ    F305
F_EXEC      equ    F306

CONTROL     equ    @par2[04]
KP          equ    @par2[11]
KI          equ    @par2[12]
KD          equ    @par2[13]

CELL1       equ    V10
APPO        equ    V11

    beg TEST_PID

    CONTROL == 3

    PID 1,2,REFPID

LOOP:

CELL1 == adc 1

APPO == (DG_MIS /50)

dac 1, APPO

goto LOOP

end
"""
