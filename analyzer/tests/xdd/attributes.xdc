<?xml version="1.0" encoding="UTF-8"?>
<ISO15745ProfileContainer xmlns="http://www.canopen.org/xml/1.0" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <ISO15745Profile>
    <ProfileHeader><ProfileClassID>Device</ProfileClassID></ProfileHeader>
    <ProfileBody xsi:type="ProfileBody_Device_CANopen" fileName="attributes.xdc" fileCreator="canvass" fileCreationDate="2026-11-21" fileVersion="1">
      <DeviceIdentity>
        <vendorName>Vendor &amp; S&#xF6;hne</vendorName>
        <vendorID>0x147</vendorID>
        <productName>Drive</productName>
        <productID>48</productID>
      </DeviceIdentity>
    </ProfileBody>
  </ISO15745Profile>
  <ISO15745Profile>
    <ProfileHeader><ProfileClassID>CommunicationNetwork</ProfileClassID></ProfileHeader>
    <ProfileBody xsi:type="ProfileBody_CommunicationNetwork_CANopen" fileName="attributes.xdc" fileCreator="canvass" fileCreationDate="2026-11-21" fileVersion="1">
      <ApplicationLayers>
        <CANopenObjectList mandatoryObjects="2" optionalObjects="4" manufacturerObjects="0">
          <CANopenObject index="1000" name="Device type" objectType="7" dataType="0007" accessType="const" defaultValue="0x00020196" PDOmapping="no"/>
          <CANopenObject index="1001" name="Error register" objectType="7" dataType="05" accessType="ro" PDOmapping="TPDO" actualValue="0"/>
          <CANopenObject index="1008" name="Manufacturer device name" objectType="7" dataType="0009" accessType="const" PDOmapping="no" actualValue="Drive &lt;1&gt;"/>
          <CANopenObject index="1800" name="TPDO 1" objectType="9" subNumber="3">
            <CANopenSubObject subIndex="00" name="Highest sub-index supported" objectType="7" dataType="0005" accessType="ro" defaultValue="2" PDOmapping="no"/>
            <CANopenSubObject subIndex="01" name="COB-ID" objectType="7" dataType="0007" accessType="rw" defaultValue="$NODEID+0x180" PDOmapping="no"/>
            <CANopenSubObject subIndex="02" name="Transmission type" objectType="7" dataType="0005" lowLimit="0" highLimit="255" accessType="rw" defaultValue="255" PDOmapping="no" objFlags="0003" actualValue="1"/>
          </CANopenObject>
          <CANopenObject index="6040" name="Controlword" objectType="7" dataType="0006" accessType="rw" PDOmapping="RPDO"/>
          <CANopenObject index="6041" name="Statusword" objectType="7" dataType="0006" accessType="ro" PDOmapping="TPDO" denotation="status of the lift"/>
        </CANopenObjectList>
        <dummyUsage>
          <dummy entry="Dummy0005=1"/>
          <dummy entry="Dummy0006=0"/>
        </dummyUsage>
      </ApplicationLayers>
      <TransportLayers>
        <PhysicalLayer>
          <baudRate defaultValue="250 Kbps">
            <supportedBaudRate value="1000 Kbps"/>
            <supportedBaudRate value="125 Kbps"/>
            <supportedBaudRate value="250 Kbps"/>
          </baudRate>
        </PhysicalLayer>
      </TransportLayers>
      <NetworkManagement>
        <CANopenGeneralFeatures groupMessaging="false" dynamicChannels="0" granularity="8" nrOfRxPDO="1" nrOfTxPDO="2" bootUpSlave="true" layerSettingServiceSlave="true"/>
        <CANopenMasterFeatures bootUpMaster="false"/>
        <deviceCommissioning nodeID="5" nodeName="Lift" actualBaudRate="250 Kbps" networkNumber="1" networkName="Line" CANopenManager="false"/>
      </NetworkManagement>
    </ProfileBody>
  </ISO15745Profile>
</ISO15745ProfileContainer>
