module bw_sensor_unit
  !! Units in laboratory files, what they measure, and their values in SI. A unit is a product of names, each with its prefix
  !! and its power, as in UDUNITS: `mm/s^2`, `m s-2`, `in/sec²`, `µm/m`, `mg`. Names of units that measure no motion are
  !! recognised, and have no factor.
  use bw_constants, only: gravity
  use bw_kinds, only: dp
  use bw_text, only: lower
  implicit none (type, external)
  private
  public :: factor_of, force_factor, is_unit, quantity_of, si_unit

  type :: unit_name
    character(8) :: word
    integer :: length, time                  !! powers of m and s
    real(dp) :: factor                       !! SI over the unit; 0 if it measures no motion
    character(9) :: prefixes = ''            !! letters of its prefixes; `l`: prefixes that are whole words
  end type unit_name

  real(dp), parameter :: inch = 0.0254_dp
  character(*), parameter :: short = 'pnumcdk', long = 'l'
  type(unit_name), parameter :: names(*) = [ &
    unit_name('s', 0, 1, 1.0_dp, short), unit_name('sec', 0, 1, 1.0_dp, short), unit_name('secs', 0, 1, 1.0_dp, short), &
    unit_name('second', 0, 1, 1.0_dp, long), unit_name('seconds', 0, 1, 1.0_dp, long), unit_name('min', 0, 1, 60.0_dp), &
    unit_name('minute', 0, 1, 60.0_dp), unit_name('minutes', 0, 1, 60.0_dp), unit_name('h', 0, 1, 3600.0_dp), &
    unit_name('hr', 0, 1, 3600.0_dp), unit_name('hour', 0, 1, 3600.0_dp), unit_name('hours', 0, 1, 3600.0_dp), &
    unit_name('day', 0, 1, 86400.0_dp), unit_name('days', 0, 1, 86400.0_dp), &
    unit_name('m', 1, 0, 1.0_dp, short), unit_name('meter', 1, 0, 1.0_dp, long), unit_name('meters', 1, 0, 1.0_dp, long), &
    unit_name('metre', 1, 0, 1.0_dp, long), unit_name('metres', 1, 0, 1.0_dp, long), unit_name('micron', 1, 0, 1.0e-6_dp), &
    unit_name('microns', 1, 0, 1.0e-6_dp), unit_name('in', 1, 0, inch), unit_name('inch', 1, 0, inch), &
    unit_name('inches', 1, 0, inch), unit_name('mil', 1, 0, 1.0e-3_dp*inch), unit_name('mils', 1, 0, 1.0e-3_dp*inch), &
    unit_name('ft', 1, 0, 12*inch), unit_name('foot', 1, 0, 12*inch), unit_name('feet', 1, 0, 12*inch), &
    unit_name('ips', 1, -1, inch), unit_name('g', 1, -2, gravity, 'num'), unit_name('gn', 1, -2, gravity), &
    unit_name('gal', 1, -2, 1.0e-2_dp, 'm'), unit_name('strain', 0, 0, 1.0_dp, 'numl'), &
    unit_name('V', 0, 0, 0.0_dp, 'num'), unit_name('Volt', 0, 0, 0.0_dp, long), unit_name('Volts', 0, 0, 0.0_dp, long), &
    unit_name('N', 0, 0, 0.0_dp, 'mkM'), unit_name('lbf', 0, 0, 0.0_dp), unit_name('Pa', 0, 0, 0.0_dp, 'umkMG'), &
    unit_name('bar', 0, 0, 0.0_dp, 'm'), unit_name('psi', 0, 0, 0.0_dp, 'k'), unit_name('Hz', 0, 0, 0.0_dp, 'kM'), &
    unit_name('rad', 0, 0, 0.0_dp, 'm'), unit_name('deg', 0, 0, 0.0_dp), unit_name('count', 0, 0, 0.0_dp), &
    unit_name('counts', 0, 0, 0.0_dp), unit_name('dB', 0, 0, 0.0_dp)]

  type :: prefix_type
    character(5) :: word
    real(dp) :: factor
  end type prefix_type

  type(prefix_type), parameter :: prefixes(*) = [prefix_type('nano', 1.0e-9_dp), prefix_type('micro', 1.0e-6_dp), &
    prefix_type('milli', 1.0e-3_dp), prefix_type('centi', 1.0e-2_dp), prefix_type('kilo', 1.0e3_dp), &
    prefix_type('p', 1.0e-12_dp), prefix_type('n', 1.0e-9_dp), prefix_type('u', 1.0e-6_dp), prefix_type('m', 1.0e-3_dp), &
    prefix_type('c', 1.0e-2_dp), prefix_type('d', 1.0e-1_dp), prefix_type('k', 1.0e3_dp), prefix_type('M', 1.0e6_dp), &
    prefix_type('G', 1.0e9_dp)]

  type :: spelling
    character(3) :: letter                   !! as in files: in UTF-8, or in Latin 1
    character(6) :: plain
  end type spelling

  type(spelling), parameter :: spellings(*) = [spelling('µ', 'u'), spelling('μ', 'u'), spelling('²', '2'), spelling('³', '3'), &
    spelling('¹', '1'), spelling('⁻', '-'), spelling('−', '-'), spelling('·', '*'), spelling('⋅', '*'), &
    spelling('ε', 'strain'), spelling('**', '^'), &
    spelling(char(181), 'u'), spelling(char(178), '2'), spelling(char(179), '3'), spelling(char(183), '*')]

  type :: sensor_unit_type
    !! A text interpreted as a unit.
    logical :: known = .false.
    logical :: named = .false.               !! it has names, and is not just `1`
    integer :: length = 0, time = 0          !! powers of m and s
    real(dp) :: factor = 1.0_dp              !! SI over the unit; 0 if a name in it measures no motion
  end type sensor_unit_type

contains

  pure type(sensor_unit_type) function unit_of(text) result(unit)
    !! Parse a unit: names between `/`, `*`, `.` and blanks, each followed by its power, or `1`.
    character(*), intent(in) :: text
    character(:), allocatable :: rest
    integer :: sign, last
    rest = plain(text)
    sign = 1
    unit%known = rest /= ''
    do while (unit%known .and. rest /= '')
      last = scan(rest//' ', '/*. ') - 1
      call multiply(unit, rest(:last), sign)
      sign = 1
      rest = adjustl(rest(last + 1:))
      if (rest == '') exit
      if (rest(1:1) == '/') sign = -1
      if (scan(rest(1:1), '/*.') > 0) rest = adjustl(rest(2:))
      unit%known = unit%known .and. rest /= ''
    end do
  end function unit_of

  pure subroutine multiply(unit, word, sign)
    !! Multiply a unit by one more factor: 1, or a name with its power.
    type(sensor_unit_type), intent(inout) :: unit
    character(*), intent(in) :: word
    integer, intent(in) :: sign              !! −1 after a `/`
    type(unit_name) :: name
    integer :: letters, digits, power, stat
    unit%known = word /= ''
    if (.not. unit%known) return
    if (word == '1') return
    letters = scan(word//'0', '0123456789^+-') - 1
    power = 1
    stat = 0
    digits = len(word)
    if (letters < len(word)) then
      digits = letters + 1
      if (word(digits:digits) == '^') digits = digits + 1
      read (word(digits:), '(i4)', iostat=stat) power
    end if
    call find_name(word(:letters), name, unit%known)
    unit%known = unit%known .and. stat == 0 .and. digits <= len(word) .and. abs(power) < 10
    if (.not. unit%known) return
    unit%named = .true.
    unit%length = unit%length + sign*power*name%length
    unit%time = unit%time + sign*power*name%time
    if (name%factor > 0) unit%factor = unit%factor*name%factor**(sign*power)
    if (.not. name%factor > 0) unit%factor = 0.0_dp
  end subroutine multiply

  pure subroutine find_name(word, name, known)
    !! Find a name with or without a prefix. Case matters only if it distinguishes units, and for names that measure no motion.
    character(*), intent(in) :: word
    type(unit_name), intent(out) :: name     !! its factor includes that of the prefix
    logical, intent(out) :: known
    integer :: i, p
    logical :: exact
    do i = 1, 2
      exact = i == 1
      do p = 0, size(prefixes)
        call find_behind(word, p, exact, name, known)
        if (known) return
      end do
    end do
  end subroutine find_name

  pure subroutine find_behind(word, p, exact, name, known)
    !! Find a name after one prefix.
    character(*), intent(in) :: word
    integer, intent(in) :: p                 !! index of the prefix; 0: none
    logical, intent(in) :: exact             !! with case as in the table
    type(unit_name), intent(out) :: name
    logical, intent(out) :: known
    integer :: i, letters, n
    known = .false.
    letters = 0
    if (p > 0) letters = len_trim(prefixes(p)%word)
    if (len(word) <= letters .or. len(word) - letters > len(name%word)) return
    if (p > 0) then
      if (.not. alike(word(:letters), prefixes(p)%word(:letters), exact)) return
    end if
    do i = 1, size(names)
      if (p > 0) then
        if (index(names(i)%prefixes, merge('l', prefixes(max(1, p))%word(1:1), letters > 1)) == 0) cycle
      end if
      n = len_trim(names(i)%word)
      known = alike(word(letters + 1:), names(i)%word(:n), exact .or. .not. names(i)%factor > 0)
      if (.not. known) cycle
      name = names(i)
      if (p > 0) name%factor = prefixes(p)%factor*name%factor
      return
    end do
  end subroutine find_behind

  pure logical function alike(word, other, exact)
    !! Return whether two words are equal, with or without regard to case.
    character(*), intent(in) :: word, other
    logical, intent(in) :: exact
    alike = len(word) == len(other)
    if (alike .and. exact) alike = word == other
    if (alike .and. .not. exact) alike = lower(word) == lower(other)
  end function alike

  pure function plain(text) result(unit)
    !! Return a unit in ASCII, without brackets around a single name.
    character(*), intent(in) :: text
    character(:), allocatable :: unit, letter
    integer :: i, at, last
    unit = trim(adjustl(text))
    if (len(unit) > 60) unit = ''            ! no unit is that long
    do i = 1, size(spellings)
      letter = trim(spellings(i)%letter)
      at = index(unit, letter)
      do while (at > 0)
        unit = unit(:at - 1)//trim(spellings(i)%plain)//unit(at + len(letter):)
        at = index(unit, letter)
      end do
    end do
    at = index(unit, '(')
    last = index(unit, ')')
    if (at == 0 .or. last < at) return
    if (scan(unit(at:last), '/* ') == 0) unit = unit(:at - 1)//unit(at + 1:last - 1)//unit(last + 1:)
  end function plain

  pure logical function is_unit(text)
    !! Return whether the text is a unit.
    character(*), intent(in) :: text
    type(sensor_unit_type) :: unit
    unit = unit_of(text)
    is_unit = unit%known
  end function is_unit

  pure function quantity_of(unit) result(quantity)
    !! Return the quantity that a unit measures, as `&record` names it; '' if not known, or not a quantity of sensors.
    character(*), intent(in) :: unit
    character(:), allocatable :: quantity
    quantity = measured_by(unit_of(unit))
    if (quantity == 'time') quantity = ''
  end function quantity_of

  pure function measured_by(unit) result(quantity)
    !! Return the quantity of a sensor, or `time`; '' if there is none.
    type(sensor_unit_type), intent(in) :: unit
    character(:), allocatable :: quantity
    quantity = ''
    if (.not. unit%known .or. .not. unit%factor > 0) return
    select case (10*unit%length + unit%time)
    case (10); quantity = 'displacement'
    case (9); quantity = 'velocity'
    case (8); quantity = 'acceleration'
    case (1); quantity = 'time'
    case (0); if (unit%named) quantity = 'strain'
    end select
  end function measured_by

  pure real(dp) function factor_of(unit, quantity) result(factor)
    !! Return SI over a unit of a quantity, or of `time`, which `since …` may follow; 0 if the unit is not known, or
    !! measures something else.
    character(*), intent(in) :: unit, quantity
    type(sensor_unit_type) :: found
    integer :: last
    last = len(unit)
    if (quantity == 'time' .and. index(unit, ' since') > 0) last = index(unit, ' since')
    found = unit_of(unit(:last))
    factor = 0.0_dp
    if (quantity /= '' .and. measured_by(found) == quantity) factor = found%factor
    if (quantity == 'strain' .and. found%known .and. .not. found%named) factor = found%factor
  end function factor_of

  pure real(dp) function force_factor(unit) result(factor)
    !! Return N over a unit of force; without a unit it is N; 0 for a unit that is not of force.
    character(*), intent(in) :: unit
    select case (trim(adjustl(unit)))
    case ('', 'N', 'n', 'newton', 'Newton', 'newtons', 'Newtons'); factor = 1
    case ('mN'); factor = 1.0e-3_dp
    case ('kN'); factor = 1.0e3_dp
    case ('lbf'); factor = 4.4482216152605_dp
    case default; factor = 0
    end select
  end function force_factor

  pure function si_unit(quantity) result(unit)
    !! Return the SI unit of a quantity of a sensor, as UDUNITS writes it.
    character(*), intent(in) :: quantity
    character(:), allocatable :: unit
    select case (quantity)
    case ('displacement'); unit = 'm'
    case ('velocity'); unit = 'm s-1'
    case ('acceleration'); unit = 'm s-2'
    case default; unit = '1'
    end select
  end function si_unit

end module bw_sensor_unit
